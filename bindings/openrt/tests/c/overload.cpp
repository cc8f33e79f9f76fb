// SPDX-License-Identifier: GPL-3.0-or-later
// Both forms of rtNewObject as overloads.
#include <openrt/rt.h>

int main()
{
    RTuint id = rtNewObject(RT_DEFINE);
    rtEndObject();
    if (rtNewObject(id, RT_COMPILE) != id)
        return 1;
    rtEndObject();
    return rtGetError() != RT_NO_ERROR;
}
