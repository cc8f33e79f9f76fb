/* SPDX-License-Identifier: GPL-3.0-or-later
 * C89 has the two-argument form of rtNewObject and rtCreateObject. */
#include <openrt/rt.h>

int main(void)
{
    RTuint id = rtCreateObject(RT_DEFINE);
    rtEndObject();
    if (rtNewObject(id, RT_COMPILE) != id)
        return 1;
    rtEndObject();
    return rtGetError() != RT_NO_ERROR;
}
