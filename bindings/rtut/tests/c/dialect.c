/* SPDX-License-Identifier: GPL-3.0-or-later
 * Every dialect of C takes the header. */
#include <openrt/rt.h>
#include <openrt/rtut.h>

int main(void)
{
    rtGenNewShaderClass("ConstantShader", 0);
    rtGenNewShader();
    rtCreateObject(RT_DEFINE);
    rtutCube();
    rtEndObject();
    return rtGetError() != RT_NO_ERROR;
}
