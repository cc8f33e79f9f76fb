/* SPDX-License-Identifier: GPL-3.0-or-later
 * Both forms of rtNewObject in C99 and later, and ways around the macro. */
#include <openrt/rt.h>

int main(void)
{
    RTuint (*function)(RTuint, RTenum) = &rtNewObject;
    RTuint id = rtNewObject(RT_DEFINE);
    rtEndObject();
    if (rtNewObject(id, RT_COMPILE) != id)
        return 1;
    rtEndObject();
    if ((rtNewObject)(id, RT_COMPILE) != id)
        return 1;
    rtEndObject();
    if (function(id, RT_COMPILE) != id)
        return 1;
    rtEndObject();
    return rtGetError() != RT_NO_ERROR;
}
