/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ray queries for C: meshes, grids, spheres, user geometry and instances, and what rays and points can ask of them. No device, no state but
 * that of scenes. Arrays are the program's own, with any gaps. docs/reference/c-rays.md has a tour.
 *
 * Every call that returns int answers 0, or -1 where something is wrong: gnurt_last_error() then says what, in this thread, and
 * nothing has been done, but that arrays for answers may be half written. Scenes may be asked by many threads at once, but not while
 * they are edited or committed. An exception that a function of the program throws ends in the library: the call answers -1.
 *
 * Additional permission under section 7 of the GNU General Public License, version 3: including this header, unmodified, in the
 * source of any work, and compiling the types, constants, macros and inline functions that it defines into that work, does not by
 * itself cause the work to be covered by the GNU General Public License. The library libgnurt itself remains covered by it.
 */
#ifndef GNURT_RAYS_H
#define GNURT_RAYS_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GNURT_NONE UINT32_MAX /* the id of nothing */

enum gnurt_type { GNURT_F32 = 0, GNURT_F64 = 1, GNURT_U32 = 2, GNURT_U64 = 3 };

/* Rows of numbers in memory: each begins `stride` bytes behind the one before; 0 is for rows without gaps. */
typedef struct gnurt_array {
    const void *data;
    size_t count;
    size_t stride;
    enum gnurt_type type;
} gnurt_array;

typedef struct gnurt_scene gnurt_scene;

/* The version of the library: 100 for 0.1.0. */
int gnurt_rays_version(void);
/* What went wrong last in this thread; empty where nothing did. It is there until the next call that goes wrong. */
const char *gnurt_last_error(void);

/* Scenes. Their geometries and instances have one row of ids, from 0 on. */
gnurt_scene *gnurt_scene_new(void);
/* Null is fine. What other scenes show of it stays for them. */
void gnurt_scene_free(gnurt_scene *);

/* How trees are built. All zeros are a good choice. */
typedef struct gnurt_build {
    int quality;      /* -1 builds fast, 1 for fast rays */
    int compact;      /* not 0: half of the memory, rays a tenth to a third slower */
    int kd;           /* not 0: kd-trees */
    int moves;        /* not 0: trees are refitted while only positions change */
    unsigned threads; /* that build: 0 for all processors, 1 for the calling thread */
    int doubles;      /* not 0: vertices, rays and answers in double precision; set it first. Triangles and instances only */
} gnurt_build;
int gnurt_scene_options(gnurt_scene *, const gnurt_build *);

/* Geometries. Positions are rows of three F32 or F64 (rounded to floats, but in scenes with `doubles`), indices rows of three or four U32 or U64, radii single numbers.
 * Arrays are read by the next commit, and not needed after that: scenes keep copies. What is written into them later is seen after
 * gnurt_set_positions and another commit. Rays see what has a bit of `mask` in common with them.
 * `id` may be null. */
int gnurt_add_triangles(gnurt_scene *, gnurt_array positions, gnurt_array indices, uint32_t mask, uint32_t *id);
int gnurt_add_quads(gnurt_scene *, gnurt_array positions, gnurt_array indices, uint32_t mask, uint32_t *id);
/* Grids of vertices, whose cells are quads in a fifth of the memory: rows of four U32 or U64, which are read at once: the first vertex, the
 * vertices from the start of a row to that of the next, columns and rows of vertices, up to 65535. prim_id counts cells, grid by
 * grid, then row by row. */
int gnurt_add_grids(gnurt_scene *, gnurt_array positions, gnurt_array grids, uint32_t mask, uint32_t *id);
int gnurt_add_spheres(gnurt_scene *, gnurt_array centers, gnurt_array radii, uint32_t mask, uint32_t *id);
/* Without normals (no data) discs face each ray. */
int gnurt_add_discs(gnurt_scene *, gnurt_array centers, gnurt_array radii, gnurt_array normals, uint32_t mask, uint32_t *id);

/* Curves with a width: hair, grass, wires. A primitive is a segment: `u` of its hits runs along it from 0 to 1, `v` across: from -1 to 1 on
 * flat ones, from 0 to 1 on oriented ones, 0 on round ones. */
enum gnurt_basis { GNURT_LINEAR = 0, GNURT_BEZIER = 1, GNURT_BSPLINE = 2, GNURT_CATMULL_ROM = 3, GNURT_HERMITE = 4 };
/* Ribbons that face each ray; tubes; ribbons across the normals of the vertices. */
enum gnurt_form { GNURT_FLAT = 0, GNURT_ROUND = 1, GNURT_ORIENTED = 2 };
typedef struct gnurt_curves {
    enum gnurt_basis basis;
    enum gnurt_form form;
    gnurt_array vertices;        /* rows of four: x, y, z, radius */
    gnurt_array segments;        /* indices of first vertices; a segment takes the next ones, too: two in all, or four of the middle three bases */
    gnurt_array tangents;        /* Hermite: rows of four, derivatives of the vertices; no data otherwise */
    gnurt_array normals;         /* oriented: rows of three; no data otherwise */
    gnurt_array normal_tangents; /* oriented and Hermite: rows of three; no data otherwise */
} gnurt_curves;
int gnurt_add_curves(gnurt_scene *, const gnurt_curves *, uint32_t mask, uint32_t *id);

/* Primitives of the program's own. Boxes are asked for by gnurt_add_user and gnurt_set_user; `intersect` is called from all threads that
 * ask, those of the library among them. */
typedef struct gnurt_user_ray {
    uint32_t prim_id;
    float org[3], dir[3], t_near, t_far; /* dir of any length: t is in multiples of it */
} gnurt_user_ray;
typedef struct gnurt_user_hit {
    float t, u, v; /* NaN in t: no hit */
} gnurt_user_hit;
typedef struct gnurt_user {
    void *user;
    uint32_t count;
    /* Boxes of primitives first to first + count - 1: least and greatest coordinates of each. */
    void (*bounds)(void *user, uint32_t first, uint32_t count, float (*boxes)[6]);
    /* Nearest hits of `count` rays, each with a primitive. As yet, `count` is 1. */
    void (*intersect)(void *user, size_t count, const gnurt_user_ray *rays, gnurt_user_hit *hits);
} gnurt_user;
int gnurt_add_user(gnurt_scene *, const gnurt_user *, uint32_t mask, uint32_t *id);

/* Another scene, as it was last committed, at a place: twelve numbers, the images of the axes and then of the origin. */
int gnurt_add_instance(gnurt_scene *, const gnurt_scene *shown, const double place[12], uint32_t mask, uint32_t *id);

/* Edits, for the next commit. Removed ids are not given again. */
int gnurt_set_positions(gnurt_scene *, uint32_t id, gnurt_array positions); /* rows of four for curves */
int gnurt_set_user(gnurt_scene *, uint32_t id, const gnurt_user *); /* other primitives, or the same where they are now */
int gnurt_set_place(gnurt_scene *, uint32_t id, const double place[12]);
int gnurt_set_shown(gnurt_scene *, uint32_t id, const gnurt_scene *shown);
int gnurt_set_mask(gnurt_scene *, uint32_t id, uint32_t mask);
int gnurt_remove(gnurt_scene *, uint32_t id);

/* Builds what queries ask from now on. Triangles that cannot be hit (bad indices, NaN, no area) are left out and counted. */
int gnurt_commit(gnurt_scene *);
typedef struct gnurt_facts {
    float lower[3], upper[3]; /* around all; lower > upper where there is nothing */
    uint64_t primitives;      /* of its own, that can be hit */
    uint64_t left_out;
    uint64_t bytes; /* of its own trees */
} gnurt_facts;
int gnurt_scene_facts(const gnurt_scene *, gnurt_facts *);

/* Queries. */
typedef struct gnurt_rays {
    size_t count;
    gnurt_array origins, directions; /* rows of three F32 or F64; one row is for all rays */
    gnurt_array t_near, t_far, masks; /* no data: 0, infinity, all bits; masks are U32 */
} gnurt_rays;

/* Where to write what of each ray; null where it is not wanted. Each place is `stride` bytes behind the one before; 0: without gaps. */
typedef struct gnurt_hits {
    size_t stride;
    float *t, *u, *v;                        /* t is infinite where nothing is hit; u, v weigh the second and third corner */
    uint32_t *prim_id, *geom_id, *inst_id;   /* GNURT_NONE where there is none; geom_id is that of the scene that has it */
    float *normal;                           /* three, of unit length, by the right-hand rule; zeros where there is none */
} gnurt_hits;

/* The same in double precision, for the calls whose names end in 64. */
typedef struct gnurt_hits64 {
    size_t stride;
    double *t, *u, *v;
    uint32_t *prim_id, *geom_id, *inst_id;
    double *normal;
} gnurt_hits64;

/* A hit that a filter decides on. */
typedef struct gnurt_candidate {
    size_t ray;
    float t, u, v;
    uint32_t prim_id, geom_id, inst_id;
} gnurt_candidate;

/* All zeros, or null, are fine. */
typedef struct gnurt_query {
    unsigned threads; /* 0 for all processors, 1 for the calling thread; answers are the same */
    int coherent;     /* not 0: neighbours go much the same way */
    /* Decides on hits of several rays at a time: writes 0 into `accept`, which is 1, to look behind them. Called by the calling
     * thread alone. */
    void (*filter)(void *user, size_t count, const gnurt_candidate *, int *accept);
    void *user;
} gnurt_query;

int gnurt_intersect(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, const gnurt_hits *);
/* The same; writes the instances on the way to each hit, too: `levels` ids for each ray, those of ray i from paths + i * levels on,
 * outermost first, each in the scene that has it. GNURT_NONE behind the last; what does not fit is left out. */
int gnurt_intersect_paths(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, const gnurt_hits *, size_t levels,
                          uint32_t *paths);
/* The same with answers in double precision. Of scenes with `doubles` t is off by less than 1e-13 of itself, and hits are exact. */
int gnurt_intersect64(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, const gnurt_hits64 *, size_t levels,
                      uint32_t *paths);
/* Writes 1 where anything is hit, else 0. */
int gnurt_occluded(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, uint8_t *occluded);
/* All hits of all rays, in the order of rays and then of t. Writes where the hits of ray i end to ends[i], and as many hits as there is
 * room for; ends[count - 1] is how many there are. `most` is the most of a ray, 0 for all. */
int gnurt_all_hits(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, size_t most, size_t *ends, size_t room,
                   const gnurt_hits *);
int gnurt_all_hits64(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, size_t most, size_t *ends, size_t room,
                     const gnurt_hits64 *);
/* How often rays cross surfaces, exactly: even through closed meshes. Filters are not asked. */
int gnurt_crossings(const gnurt_scene *, const gnurt_rays *, const gnurt_query *, uint32_t *counts);
/* Points are rows of three. 1 where closed meshes contain them, else 0. */
int gnurt_contains(const gnurt_scene *, gnurt_array points, const gnurt_query *, uint8_t *contained);
/* Distances to surfaces, negative inside of closed meshes. */
int gnurt_signed_distances(const gnurt_scene *, gnurt_array points, const gnurt_query *, double *distances);
/* Nearest points of surfaces no farther than `radius`: each point if `nearest` is not null, and of the hits t (the distance), u, v, ids and normal. */
int gnurt_closest_points(const gnurt_scene *, gnurt_array points, double radius, const gnurt_query *, double (*nearest)[3],
                         const gnurt_hits *);
int gnurt_closest_points64(const gnurt_scene *, gnurt_array points, double radius, const gnurt_query *, double (*nearest)[3],
                           const gnurt_hits64 *);

#ifdef __cplusplus
}
#endif
#endif
