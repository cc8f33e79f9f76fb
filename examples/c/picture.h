/* SPDX-License-Identifier: GPL-3.0-or-later
 * For the examples: writing frame buffers of three bytes per pixel to PPM files. PPM begins with the top row, frame buffers
 * with the lowest one. */
#ifndef PICTURE_H
#define PICTURE_H

#include <stdio.h>

/* Returns 0 if the file could be written. */
static inline int write_ppm(const char *path, const unsigned char *pixels, int width, int height)
{
    FILE *file = fopen(path, "wb");
    int row;
    if (file == NULL) {
        fprintf(stderr, "cannot write %s\n", path);
        return 1;
    }
    fprintf(file, "P6\n%d %d\n255\n", width, height);
    for (row = height - 1; row >= 0; row--)
        fwrite(pixels + (size_t)row * (size_t)width * 3, 3, (size_t)width, file);
    return fclose(file) != 0;
}

#endif
