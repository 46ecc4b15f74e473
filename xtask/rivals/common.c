#define _POSIX_C_SOURCE 200809L
#include "common.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void die(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("error: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    exit(1);
}

double milliseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1e3 + now.tv_nsec * 1e-6;
}

static void *take(size_t bytes) {
    void *memory = malloc(bytes);
    if (!memory) die("no memory for %zu bytes", bytes);
    return memory;
}

struct options read_options(int argc, char **argv) {
    struct options o = {.width = 1024, .height = 1024, .threads = 2, .samples = 1, .opacity = 1};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (!strcmp(argv[i], "--cull")) {
            o.cull = true;
        } else if (!strcmp(argv[i], "--size")) {
            if (sscanf(value, "%dx%d", &o.width, &o.height) != 2) die("--size wants WxH, found \"%s\"", value);
            i++;
        } else if (!strcmp(argv[i], "--threads")) {
            if (sscanf(value, "%d", &o.threads) != 1) die("--threads wants a number, found \"%s\"", value);
            i++;
        } else if (!strcmp(argv[i], "--samples")) {
            if (sscanf(value, "%d", &o.samples) != 1) die("--samples wants a number, found \"%s\"", value);
            i++;
        } else if (!strcmp(argv[i], "--opacity")) {
            if (sscanf(value, "%lf", &o.opacity) != 1) die("--opacity wants a number, found \"%s\"", value);
            i++;
        } else if (!strcmp(argv[i], "--picture")) {
            o.picture = value;
            i++;
        } else if (!o.model) {
            o.model = argv[i];
        } else if (!o.views) {
            o.views = argv[i];
        } else {
            die("%s is not understood", argv[i]);
        }
    }
    if (!o.views)
        die("wanted: MODEL.ply VIEWS [--size WxH] [--threads N] [--cull] [--samples N] [--opacity A] "
            "[--picture FILE.ppm]");
    if (o.width < 1 || o.height < 1 || o.threads < 1 || o.samples < 1) die("sizes, threads and samples begin with 1");
    if (!(o.opacity > 0 && o.opacity <= 1)) die("an opacity is above 0 and at most 1");
    return o;
}

/* Reads only the header that `cargo xtask models` writes. */
static void read_header(FILE *file, const char *path, struct mesh *mesh) {
    static const char *const lines[] = {
        "ply\n", "format binary_little_endian 1.0\n", "element vertex ", "property float x\n",
        "property float y\n", "property float z\n", "property float nx\n", "property float ny\n",
        "property float nz\n", "element face ", "property list uchar int vertex_indices\n", "end_header\n",
    };
    char line[128];
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        size_t length = strlen(lines[i]);
        if (!fgets(line, sizeof line, file)) die("%s: ends inside the header", path);
        if (strncmp(line, lines[i], length)) die("%s:%zu: expected %s, found %s", path, i + 1, lines[i], line);
        if (i == 2) mesh->vertices = strtoul(line + length, NULL, 10);
        if (i == 9) mesh->triangles = strtoul(line + length, NULL, 10);
    }
}

static void read_bytes(FILE *file, const char *path, void *to, size_t bytes) {
    if (fread(to, 1, bytes, file) != bytes) die("%s: ends too early", path);
}

struct mesh read_mesh(const char *path) {
    enum { FACE_BYTES = 13, FACES_AT_ONCE = 4096 };
    FILE *file = fopen(path, "rb");
    if (!file) die("%s: cannot be opened", path);
    struct mesh mesh = {0};
    read_header(file, path, &mesh);
    size_t bytes = (size_t)mesh.vertices * FLOATS_A_VERTEX * sizeof(float);
    mesh.attributes = take(bytes + 16);
    memset((char *)mesh.attributes + bytes, 0, 16);
    read_bytes(file, path, mesh.attributes, bytes);
    mesh.indices = take((size_t)mesh.triangles * 3 * sizeof(uint32_t));
    static uint8_t faces[FACE_BYTES * FACES_AT_ONCE];
    for (uint32_t t = 0; t < mesh.triangles; t++) {
        uint32_t place = t % FACES_AT_ONCE, left = mesh.triangles - t;
        if (place == 0) read_bytes(file, path, faces, FACE_BYTES * (left < FACES_AT_ONCE ? left : FACES_AT_ONCE));
        uint32_t *corners = mesh.indices + (size_t)t * 3;
        if (faces[place * FACE_BYTES] != 3) die("%s: face %u is no triangle", path, t);
        memcpy(corners, faces + place * FACE_BYTES + 1, 12);
        for (int k = 0; k < 3; k++)
            if (corners[k] >= mesh.vertices) die("%s: face %u: there is no vertex %u", path, t, corners[k]);
    }
    fclose(file);
    for (int k = 0; k < 3; k++) mesh.min[k] = INFINITY, mesh.max[k] = -INFINITY;
    for (size_t v = 0; v < mesh.vertices; v++)
        for (int k = 0; k < 3; k++) {
            float p = mesh.attributes[v * FLOATS_A_VERTEX + k];
            mesh.min[k] = fminf(mesh.min[k], p);
            mesh.max[k] = fmaxf(mesh.max[k], p);
        }
    return mesh;
}

struct views read_views(const char *path) {
    FILE *file = fopen(path, "r");
    if (!file) die("%s: cannot be opened", path);
    struct views views = {0};
    int room = 0, copy_room = 0;
    char word[16];
    while (fscanf(file, "%15s", word) == 1) {
        if (!strcmp(word, "view")) {
            if (views.count == room) views.view = realloc(views.view, (room = room * 2 + 8) * sizeof *views.view);
            struct view *v = views.view + views.count++;
            double *vectors[4] = {v->eye, v->right, v->up, v->forward};
            for (int i = 0; i < 12; i++)
                if (fscanf(file, "%lf", vectors[i / 3] + i % 3) != 1) die("%s: view %d: number", path, views.count);
            if (fscanf(file, "%lf", &v->tangent) != 1) die("%s: view %d: no tangent", path, views.count);
        } else if (!strcmp(word, "copy")) {
            if (views.copies == copy_room)
                views.copy = realloc(views.copy, (copy_room = copy_room * 2 + 8) * sizeof *views.copy);
            double *c = views.copy[views.copies++];
            if (fscanf(file, "%lf %lf %lf", c, c + 1, c + 2) != 3) die("%s: copy %d: number", path, views.copies);
        } else {
            die("%s: \"%s\" is not understood", path, word);
        }
    }
    fclose(file);
    if (views.count < 1 || views.copies < 1) die("%s: no view or no copy", path);
    return views;
}

void depth_range(const struct mesh *mesh, const struct views *views, const struct view *view, double range[2]) {
    range[0] = INFINITY, range[1] = -INFINITY;
    for (int copy = 0; copy < views->copies; copy++)
        for (int corner = 0; corner < 8; corner++) {
            double along = 0;
            for (int k = 0; k < 3; k++) {
                double p = (corner >> k & 1 ? mesh->max[k] : mesh->min[k]) + views->copy[copy][k];
                along += view->forward[k] * (p - view->eye[k]);
            }
            range[0] = fmin(range[0], along), range[1] = fmax(range[1], along);
        }
    double size = range[1] - range[0];
    /* A plane seen from the front has no extent along the line of sight. */
    double margin = fmax(0.01 * size, 1e-4 * fabs(range[1]));
    /* An eye inside the model: as near as 24 bits of depth allow. */
    range[0] = fmax(range[0] - margin, 1e-3 * size);
    range[1] += margin;
}

struct frames new_frames(int count) {
    return (struct frames){take(count * sizeof(double)), take(count * sizeof(uint64_t))};
}

uint64_t count_pixels(const uint8_t *rgba, size_t pixels) {
    uint64_t count = 0;
    for (size_t i = 0; i < pixels; i++) count += rgba[i * 4 + 3] != 0;
    return count;
}

void write_picture(const char *path, const uint8_t *rgba, int width, int height, bool upwards) {
    FILE *file = fopen(path, "wb");
    if (!file) die("%s: cannot be written", path);
    fprintf(file, "P6\n%d %d\n255\n", width, height);
    for (int row = 0; row < height; row++) {
        const uint8_t *pixels = rgba + (size_t)(upwards ? height - 1 - row : row) * width * 4;
        for (int x = 0; x < width; x++) fwrite(pixels + (size_t)x * 4, 1, 3, file);
    }
    if (fclose(file)) die("%s: cannot be written", path);
}

void report(const struct frames *frames, int count, const char *facts) {
    printf("{%s, \"views\": [", facts);
    for (int i = 0; i < count; i++)
        printf("%s{\"milliseconds\": %.4f, \"pixels\": %llu}", i ? ", " : "", frames->milliseconds[i],
               (unsigned long long)frames->pixels[i]);
    puts("]}");
}
