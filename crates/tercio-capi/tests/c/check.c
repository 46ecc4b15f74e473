/* Calls every function of a session, wrong and right: check alone|mpi|split ORGANISATION FOLDER. The test draws the same in Rust.
 * With "split" every second process draws for itself, at the same time, into FOLDER/other; ranks are numbered from the last process on. */
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <tercio.h>

enum { CELLS = 24, WIDE = CELLS + 1 };

static int rank = 0, processes = 1;

#define RIGHT(call)                                                                             \
    do {                                                                                        \
        if ((call) != 0) {                                                                      \
            fprintf(stderr, "rank %d, line %d: %s\n", rank, __LINE__, tercio_last_error());     \
            exit(3);                                                                            \
        }                                                                                       \
    } while (0)

/* Must fail, with these words. */
#define WRONG(call, words)                                                                      \
    do {                                                                                        \
        if ((call) == 0 || strstr(tercio_last_error(), words) == NULL) {                        \
            fprintf(stderr, "rank %d, line %d: %s\n", rank, __LINE__, tercio_last_error());     \
            exit(4);                                                                            \
        }                                                                                       \
    } while (0)

/* This process's rows of a saddle. All coordinates are exact. */
static double positions[WIDE * WIDE][3];
static uint8_t colors[WIDE * WIDE][4];
static uint32_t corners[2 * CELLS * CELLS][3];

static tercio_arrays saddle(double scale, double lift) {
    int first = CELLS * rank / processes, last = CELLS * (rank + 1) / processes, v = 0, t = 0;
    for (int y = first; y <= last; y++)
        for (int x = 0; x < WIDE; x++, v++) {
            positions[v][0] = x;
            positions[v][1] = y;
            positions[v][2] = scale * ((x - 12) * (x - 12) - (y - 12) * (y - 12)) / 64.0 + lift;
            colors[v][0] = (uint8_t)(10 * x), colors[v][1] = (uint8_t)(10 * y), colors[v][2] = 90, colors[v][3] = 255;
        }
    for (int y = 0; y < last - first; y++)
        for (int x = 0; x < CELLS; x++) {
            uint32_t a = (uint32_t)(y * WIDE + x);
            uint32_t two[2][3] = {{a, a + 1, a + WIDE + 1}, {a, a + WIDE + 1, a + WIDE}};
            memcpy(corners[t], two, sizeof two);
            t += 2;
        }
    tercio_arrays arrays = {0};
    arrays.vertices = (size_t)v;
    arrays.positions_f64 = positions[0];
    arrays.colors = colors[0];
    arrays.triangles = (size_t)t;
    arrays.corners = corners[0];
    return arrays;
}

int main(int argc, char **argv) {
    if (argc != 4) return 2;
    int is_alone = strcmp(argv[1], "alone") == 0, is_split = strcmp(argv[1], "split") == 0, is_other = 0;
    tercio_session *s;
    WRONG(tercio_render(NULL), "the session is NULL");
    WRONG(tercio_open_mpi(NULL) != NULL ? 0 : 1, "the communicator is NULL");
    RIGHT(tercio_set_threads(1));
    if (is_alone) {
        s = tercio_open();
    } else {
        int threads_allowed;
        MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &threads_allowed);
        MPI_Comm comm = MPI_COMM_WORLD;
        MPI_Comm_rank(comm, &rank);
        if (is_split) {
            is_other = rank % 2;
            MPI_Comm_split(MPI_COMM_WORLD, is_other, -rank, &comm);
        }
        MPI_Comm_rank(comm, &rank);
        MPI_Comm_size(comm, &processes);
        s = tercio_open_mpi(&comm);
        /* The session has its own. */
        if (is_split) MPI_Comm_free(&comm);
    }
    RIGHT(s == NULL);
    WRONG(tercio_set_threads(3), "1 threads draw already");
    RIGHT(tercio_set_timeout(s, 100));
    WRONG(tercio_set_timeout(s, -1), "expected seconds");
    RIGHT(tercio_set_picture(s, 160, 120, 4));
    WRONG(tercio_set_picture(s, 160, 120, 3), "samples must be 1, 2, 4, 8 or 16, found 3");
    WRONG(tercio_set_picture(s, 0, 120, 4), "");
    RIGHT(tercio_set_organisation(s, argv[2]));
    WRONG(tercio_set_organisation(s, "sort-never"), "found \"sort-never\"");
    double background[4] = {0.2, 0.3, 0.4, 1}, too_bright[4] = {2, 0, 0, 1};
    RIGHT(tercio_set_background(s, background));
    WRONG(tercio_set_background(s, too_bright), "expected numbers from 0 to 1, found 2");
    RIGHT(tercio_set_up_axis(s, 'z'));
    WRONG(tercio_set_up_axis(s, 'w'), "found 'w'");
    if (rank == 0) WRONG(tercio_save(s, "none.png"), "no picture was drawn yet");

    /* Parts: a saddle; a square of process 0, then turned and placed; one that is removed again. */
    uint32_t part, square, gone;
    tercio_arrays arrays = saddle(1, 0);
    RIGHT(tercio_add(s, &arrays, &part));
    float places[4][3] = {{0, 0, 1}, {8, 0, 1}, {8, 8, 1}, {0, 8, 1}}, normals[4][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    uint32_t halves[2][3] = {{0, 1, 2}, {0, 2, 3}};
    tercio_arrays flat = {0};
    if (rank == 0) {
        flat.vertices = 4, flat.positions_f32 = places[0], flat.normals = normals[0];
        flat.triangles = 2, flat.corners = halves[0];
    }
    RIGHT(tercio_add(s, &flat, &square));
    RIGHT(tercio_add(s, &arrays, &gone));
    RIGHT(tercio_remove(s, gone));
    RIGHT(part != 0 || square != 1 || gone != 2);
    WRONG(tercio_remove(s, gone), "there is no part 2");
    WRONG(tercio_update(s, gone, &arrays), "there is no part 2");
    double red[3] = {0.9, 0.2, 0.1}, turn[16] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 16, 4, 2, 1}, none[16] = {0};
    RIGHT(tercio_set_surface(s, square, red, 0.5));
    WRONG(tercio_set_surface(s, square, red, 1.5), "found 1.5");
    RIGHT(tercio_set_transform(s, square, turn));
    WRONG(tercio_set_transform(s, square, none), "the matrix must be finite");

    /* Arrays that are wrong on one process only. */
    arrays = saddle(2, 0);
    tercio_arrays wrong = arrays;
    if (rank == processes - 1) wrong.corners = NULL;
    WRONG(tercio_update(s, part, &wrong), rank == processes - 1 ? "but no corners" : "could not make its part");
    uint32_t kept = corners[1][2];
    corners[1][2] = 99999;
    WRONG(tercio_update(s, part, &arrays), "corner 2 of triangle 1 is vertex 99999");
    corners[1][2] = kept;
    RIGHT(tercio_update(s, part, &arrays));

    /* Shown once. */
    char path[2048], folder[1024];
    snprintf(folder, sizeof folder, "%s%s", argv[3], is_other ? "/other" : "");
    arrays = saddle(-0.5, 4);
    RIGHT(tercio_show(s, &arrays));
    WRONG(tercio_fit_camera(s, 20, 30, 0), "the zoom above 0");
    RIGHT(tercio_fit_camera(s, 20, 30, 1.25));
    const uint8_t *pixels = (const uint8_t *)&s;
    uint32_t wide = 7, high = 7;
    RIGHT(tercio_pixels(s, &pixels, &wide, &high));
    RIGHT(pixels != NULL || wide != 0 || high != 0);
    RIGHT(tercio_render(s));
    snprintf(path, sizeof path, "%s/first.png", folder);
    RIGHT(tercio_save(s, path));

    double eye[3] = {-20, -30, 25}, target[3] = {12, 12, 0}, up[3] = {0, 0, 1};
    WRONG(tercio_set_camera(s, eye, eye, up, 40), "");
    RIGHT(tercio_set_camera(s, eye, target, up, 40));
    RIGHT(tercio_render(s));
    snprintf(path, sizeof path, "%s/second.png", folder);
    RIGHT(tercio_save(s, path));
    RIGHT(tercio_pixels(s, &pixels, &wide, &high));
    if (rank == 0) {
        RIGHT(pixels == NULL || wide != 160 || high != 120);
        snprintf(path, sizeof path, "%s/second.raw", folder);
        FILE *file = fopen(path, "wb");
        RIGHT(file == NULL || fwrite(pixels, 4, wide * high, file) != wide * high || fclose(file) != 0);
    } else {
        RIGHT(pixels != NULL || wide != 0);
    }
    RIGHT(!(tercio_seconds_spent(s) > 0) || tercio_seconds_spent(NULL) >= 0);

    /* A process that calls another function is an error of all, and no process waits for ever. */
    if (processes > 1) {
        if (rank == 1) WRONG(tercio_fit_camera(s, 0, 0, 1), "rank 1 called camera, and rank 0 render");
        else WRONG(tercio_render(s), "rank 1 called camera, and rank 0 render");
        WRONG(tercio_show(s, &arrays), "the session failed before: ");
    }
    RIGHT(tercio_close(s));
    RIGHT(tercio_close(NULL));
    if (!is_alone) MPI_Finalize();
    return 0;
}
