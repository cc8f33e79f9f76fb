/* SPDX-License-Identifier: GPL-3.0-or-later
 * The sizes of the structures of rts.h, in C and in C++: those that src/ffi_rts.rs has. */
#include <openrt/rts.h>

#include <stdio.h>

int main(void)
{
    const size_t sizes[7] = { sizeof(RTSvec), sizeof(RTSparam), sizeof(RTSrays), sizeof(RTShits),
                              sizeof(RTShost), sizeof(RTSclass), sizeof(RTSmodule) };
    const size_t wanted[7] = { 24, 24, 88, 232, 72, 128, 24 };
    int i, failures = 0;
    if (sizeof(void *) != 8)
        return 0;
    for (i = 0; i < 7; i++)
        if (sizes[i] != wanted[i]) {
            printf("structure %d has %d bytes, not %d\n", i, (int)sizes[i], (int)wanted[i]);
            failures++;
        }
    failures += offsetof(RTSclass, init) != 56 || offsetof(RTShits, back) != 224 || offsetof(RTShost, log) != 64;
    failures += sizeof(RTSvec) != sizeof(RTSvecm) || RTS_ABI >> 16 != 1;
    return failures;
}
