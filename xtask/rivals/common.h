/* Shared by the rivals: the mesh file, the views, the clock, and the report. Plain C11 for one machine's speed
 * measurements; files come from `cargo xtask models`, so a failed check just ends the program with one line. */
#ifndef RIVALS_COMMON_H
#define RIVALS_COMMON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { FLOATS_A_VERTEX = 6 };

/* Triangles with shared vertices, object space. */
struct mesh {
    uint32_t vertices, triangles;
    float *attributes; /* x y z nx ny nz a vertex; 16 bytes after the last are readable, too */
    uint32_t *indices; /* three a triangle, counter-clockwise seen from outside */
    float min[3], max[3];
};

/* A perspective camera in world space; the axes are orthonormal. */
struct view {
    double eye[3], right[3], up[3], forward[3];
    double tangent; /* of half the vertical angle of view */
};

/* The views, one a frame, and the positions of the copies of the mesh. */
struct views {
    int count, copies;
    struct view *view;
    double (*copy)[3]; /* offsets; at least one */
};

/* The command line: PROGRAM MODEL.ply VIEWS [--size WxH] [--threads N] [--cull] [--samples N] [--opacity A]
 * [--picture FILE.ppm]. Embree has one sample per pixel and opaque surfaces only. */
struct options {
    const char *model, *views, *picture;
    int width, height, threads, samples;
    double opacity;
    bool cull;
};

/* The measurements of each frame. */
struct frames {
    double *milliseconds;
    uint64_t *pixels; /* that show a triangle */
};

_Noreturn void die(const char *format, ...);
double milliseconds(void);
struct options read_options(int argc, char **argv);
struct mesh read_mesh(const char *path);
struct views read_views(const char *path);
/* The range of distances along the line of sight of the mesh and all its copies. */
void depth_range(const struct mesh *mesh, const struct views *views, const struct view *view, double range[2]);
struct frames new_frames(int count);
/* Pixels of RGBA bytes whose alpha is not 0. */
uint64_t count_pixels(const uint8_t *rgba, size_t pixels);
/* RGBA bytes as PPM; `upwards` if the first row is the lowest one. */
void write_picture(const char *path, const uint8_t *rgba, int width, int height, bool upwards);
/* The frames as JSON on standard output; `facts` are additional members, such as "\"version\": \"1\"". */
void report(const struct frames *frames, int count, const char *facts);

#endif
