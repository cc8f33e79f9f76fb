/* SPDX-License-Identifier: GPL-3.0-or-later
 * Loads a class and checks the error and a part of the info log.
 * Usage: plugin_load CLASS FILE none|value|operation [PART OF LOG] */
#include "check.h"

int main(int argc, char **argv)
{
    const char *log;
    RTenum error, wanted;
    RTuint id;
    if (argc < 4)
        return 2;
    wanted = argv[3][0] == 'n' ? RT_NO_ERROR : argv[3][0] == 'v' ? RT_INVALID_VALUE : RT_INVALID_OPERATION;
    id = rtGenNewShaderClass(argv[1], argv[2]);
    error = rtGetError();
    log = rtGetShaderClassInfoLog();
    printf("%s\n", log);
    if (error != wanted)
        printf("error %#x, not %#x\n", error, wanted);
    CHECK(error == wanted);
    CHECK((id == RT_INVALID) == (wanted != RT_NO_ERROR));
    CHECK((log[0] == 0) == (wanted == RT_NO_ERROR));
    if (argc > 4)
        CHECK(strstr(log, argv[4]) != NULL);
    if (wanted == RT_NO_ERROR) {
        CHECK(rtGenNewShaderClass(argv[1], argv[2]) == id);
        CHECK(rtGenNewShader() != RT_INVALID);
        CHECK(rtGenNewShaderClass("no such class", argv[2]) == RT_INVALID);
        CHECK(rtGetError() == RT_INVALID_VALUE);
        CHECK(strstr(rtGetShaderClassInfoLog(), argv[1]) != NULL);
        rtExit();
        /* From the start, with the library closed and opened again. */
        CHECK(rtGenNewShaderClass(argv[1], argv[2]) != RT_INVALID);
    }
    FINISH();
}
