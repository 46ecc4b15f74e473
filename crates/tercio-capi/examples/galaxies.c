/*
 * Two galaxies meet: bodies that attract each other, by direct summation, divided among the processes of an MPI job, drawn while they
 * move.
 *
 *     cargo xtask capi --mpi --prefix PREFIX
 *     mpicc -O3 galaxies.c -o galaxies $(PKG_CONFIG_PATH=PREFIX/lib/pkgconfig pkg-config --cflags --libs tercio) -lm
 *     LD_LIBRARY_PATH=PREFIX/lib mpirun -n 2 ./galaxies --pictures galaxies
 *
 * Bodies are immediate: their triangles are arrays of this program, shown in one picture. The two cores are retained: the same ball, put
 * to its place for each picture. Pictures do not depend on the number of processes.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <math.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include <tercio.h>

static int rank, processes;

/* Ends the job with what tercio says. */
static void check(int failed) {
    if (failed) {
        fprintf(stderr, "error: rank %d: %s\n", rank, tercio_last_error());
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
}

static void *memory(size_t count, size_t size) {
    void *p = calloc(count > 0 ? count : 1, size);
    if (p == NULL) {
        fprintf(stderr, "error: rank %d: no memory\n", rank);
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    return p;
}

/* ---- The simulation. ---- */

static const double STEP = 0.002, SOFTENING = 0.05, CORE = 1.0, DISC = 0.2, TAU = 6.283185307179586;

/* All bodies; this process moves those from `first` to `last`. Body 0 and body n/2 are the cores. */
static int n, first, last;
static double *mass, *place[3], *velocity[3], *force[3];

/* A number from 0 to 1 that belongs to a body. */
static double chance(int body, int which) {
    uint64_t z = ((uint64_t)body * 8 + (uint64_t)which + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

/* Two discs that approach each other, the second one tilted. */
static void begin(void) {
    mass = memory(n, sizeof *mass);
    for (int k = 0; k < 3; k++) {
        place[k] = memory(n, sizeof **place);
        velocity[k] = memory(n, sizeof **velocity);
        force[k] = memory(n, sizeof **force);
    }
    for (int i = 0; i < n; i++) {
        int half = n / 2, of_second = i >= half, is_core = i == 0 || i == half;
        int members = of_second ? n - half : half;
        double p[3] = {0, 0, 0}, v[3] = {0, 0, 0};
        if (!is_core) {
            double radius = sqrt(0.06 + 1.2 * chance(i, 0)), angle = TAU * chance(i, 1);
            double speed = sqrt((CORE + DISC * radius * radius / 1.26) / radius);
            p[0] = radius * cos(angle), p[1] = radius * sin(angle), p[2] = 0.06 * (chance(i, 2) - 0.5);
            v[0] = -speed * sin(angle), v[1] = speed * cos(angle);
        }
        double tilt = of_second ? 1.1 : 0.15, c = cos(tilt), s = sin(tilt), side = of_second ? -1 : 1;
        double turned[2][3] = {{p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]}, {v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]}};
        double to[2][3] = {{1.6 * side, 0.7 * side, 0}, {-0.55 * side, 0.1 * side, 0}};
        for (int k = 0; k < 3; k++) {
            place[k][i] = turned[0][k] + to[0][k];
            velocity[k][i] = turned[1][k] + to[1][k];
        }
        mass[i] = is_core ? CORE : DISC / (members > 1 ? members - 1 : 1);
    }
}

/* The attraction of all bodies on those of this process, in an order that does not depend on who has them. */
static void attract(void) {
    enum { BLOCK = 256 };
    double *restrict fx = force[0], *restrict fy = force[1], *restrict fz = force[2];
    const double *x = place[0], *y = place[1], *z = place[2];
    for (int start = first; start < last; start += BLOCK) {
        int end = start + BLOCK < last ? start + BLOCK : last;
        for (int i = start; i < end; i++) fx[i] = fy[i] = fz[i] = 0;
        for (int j = 0; j < n; j++) {
            double xj = x[j], yj = y[j], zj = z[j], m = mass[j];
            for (int i = start; i < end; i++) {
                double dx = xj - x[i], dy = yj - y[i], dz = zj - z[i];
                double square = dx * dx + dy * dy + dz * dz + SOFTENING * SOFTENING;
                double pull = m / (square * sqrt(square));
                fx[i] += pull * dx, fy[i] += pull * dy, fz[i] += pull * dz;
            }
        }
    }
}

/* Half a kick, a drift, half a kick; then every process gets the new places of all bodies. */
static void step(const int *counts, const int *starts) {
    for (int k = 0; k < 3; k++)
        for (int i = first; i < last; i++) {
            velocity[k][i] += 0.5 * STEP * force[k][i];
            place[k][i] += STEP * velocity[k][i];
        }
    for (int k = 0; k < 3; k++)
        MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, place[k], counts, starts, MPI_DOUBLE, MPI_COMM_WORLD);
    attract();
    for (int k = 0; k < 3; k++)
        for (int i = first; i < last; i++) velocity[k][i] += 0.5 * STEP * force[k][i];
}

/* Kinetic and potential energy of all bodies, on process 0: it should stay. */
static double energy(void) {
    double own = 0, all = 0;
    for (int i = first; i < last; i++) {
        for (int k = 0; k < 3; k++) own += 0.5 * mass[i] * velocity[k][i] * velocity[k][i];
        for (int j = 0; j < n; j++) {
            double square = SOFTENING * SOFTENING;
            for (int k = 0; k < 3; k++) square += (place[k][j] - place[k][i]) * (place[k][j] - place[k][i]);
            if (j != i) own -= 0.5 * mass[i] * mass[j] / sqrt(square);
        }
    }
    MPI_Reduce(&own, &all, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    return all;
}

/* ---- The picture. ---- */

static const int8_t CORNERS[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
static const uint32_t FACES[8][3] = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};

/* The arrays of this process's bodies. */
static float (*positions)[3], (*normals)[3];
static uint8_t (*colors)[4];
static uint32_t (*corners)[3];

/* An octahedron for each body, with the normals of a ball; its colour says how fast it moves. */
static struct tercio_arrays bodies(void) {
    int count = last - first;
    if (positions == NULL) {
        positions = memory(6 * (size_t)count, sizeof *positions);
        normals = memory(6 * (size_t)count, sizeof *normals);
        colors = memory(6 * (size_t)count, sizeof *colors);
        corners = memory(8 * (size_t)count, sizeof *corners);
    }
    for (int b = 0; b < count; b++) {
        int i = first + b;
        double v = 0;
        for (int k = 0; k < 3; k++) v += velocity[k][i] * velocity[k][i];
        double t = fmin(sqrt(v) / 2.5, 1);
        uint8_t warm[3] = {(uint8_t)(255 - 25 * t), (uint8_t)(120 + 120 * t), (uint8_t)(50 + 190 * t)};
        uint8_t cold[3] = {(uint8_t)(60 + 170 * t), (uint8_t)(130 + 110 * t), 255};
        for (int c = 0; c < 6; c++) {
            for (int k = 0; k < 3; k++) {
                positions[6 * b + c][k] = (float)(place[k][i] + 0.014 * CORNERS[c][k]);
                normals[6 * b + c][k] = CORNERS[c][k];
                colors[6 * b + c][k] = i < n / 2 ? warm[k] : cold[k];
            }
            colors[6 * b + c][3] = 255;
        }
        for (int f = 0; f < 8; f++)
            for (int k = 0; k < 3; k++) corners[8 * b + f][k] = 6 * (uint32_t)b + FACES[f][k];
    }
    struct tercio_arrays arrays = {0};
    arrays.vertices = 6 * (size_t)count;
    arrays.positions_f32 = positions[0];
    arrays.normals = normals[0];
    arrays.colors = colors[0];
    arrays.triangles = 8 * (size_t)count;
    arrays.corners = corners[0];
    return arrays;
}

/* Adds a ball of radius 1, with which the first process begins. */
static uint32_t add_ball(tercio_session *session, double red, double green, double blue) {
    enum { ACROSS = 16, AROUND = 32, POINTS = (ACROSS + 1) * AROUND };
    static double points[POINTS][3];
    static uint32_t triangles[2 * ACROSS * AROUND][3];
    for (int a = 0; a <= ACROSS; a++)
        for (int b = 0; b < AROUND; b++) {
            double theta = TAU / 2 * a / ACROSS, phi = TAU * b / AROUND;
            double *p = points[a * AROUND + b];
            p[0] = sin(theta) * cos(phi), p[1] = sin(theta) * sin(phi), p[2] = cos(theta);
        }
    int count = 0;
    for (uint32_t a = 0; a < ACROSS; a++)
        for (uint32_t b = 0; b < AROUND; b++) {
            uint32_t here = a * AROUND + b, beside = a * AROUND + (b + 1) % AROUND;
            uint32_t square[2][3] = {{here, here + AROUND, beside + AROUND}, {here, beside + AROUND, beside}};
            for (int t = 0; t < 2; t++) memcpy(triangles[count++], square[t], sizeof square[t]);
        }
    struct tercio_arrays ball = {0};
    if (rank == 0) {
        ball.vertices = POINTS;
        ball.positions_f64 = points[0];
        ball.triangles = (size_t)count;
        ball.corners = triangles[0];
    }
    uint32_t part;
    double rgb[3] = {red, green, blue};
    check(tercio_add(session, &ball, &part));
    check(tercio_set_surface(session, part, rgb, 1));
    return part;
}

static void draw(tercio_session *session, const uint32_t cores[2]) {
    for (int c = 0; c < 2; c++) {
        int i = c * (n / 2);
        double size = 0.07, matrix[16] = {size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0, place[0][i], place[1][i], place[2][i], 1};
        check(tercio_set_transform(session, cores[c], matrix));
    }
    struct tercio_arrays arrays = bodies();
    check(tercio_show(session, &arrays));
    check(tercio_render(session));
}

/* ---- The program. ---- */

/* Elapsed seconds, and seconds of the processors. */
struct seconds {
    double elapsed, processor;
};

static struct seconds now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (struct seconds){MPI_Wtime(), (double)t.tv_sec + 1e-9 * (double)t.tv_nsec};
}

static void add_since(struct seconds *sum, struct seconds begin) {
    struct seconds end = now();
    sum->elapsed += end.elapsed - begin.elapsed;
    sum->processor += end.processor - begin.processor;
}

/* What drawing has taken from the simulation, on the process where it took the most. */
static void report(struct seconds all, struct seconds drawing, struct seconds writing) {
    double own[6] = {all.elapsed, drawing.elapsed, writing.elapsed, all.processor, drawing.processor, writing.processor}, most[6];
    MPI_Reduce(own, most, 6, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    const char *names[2] = {"elapsed", "processor"};
    for (int k = 0; rank == 0 && k < 2; k++) {
        double *m = most + 3 * k, simulation = m[0] - m[1] - m[2];
        printf("%s seconds: %.2f simulation, %.2f drawing (%.1f %%), %.2f writing\n", names[k], simulation, m[1], 100 * m[1] / simulation,
               m[2]);
    }
}

int main(int argc, char **argv) {
    int threads_allowed;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &threads_allowed);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &processes);
    int steps = 2000, every = 10, wide = 1024, high = 768, wrong = 0;
    const char *folder = NULL;
    n = 6000;
    for (int a = 1; a < argc; a += 2) {
        const char *name = argv[a], *value = a + 1 < argc ? argv[a + 1] : "";
        char more;
        if (!strcmp(name, "--bodies")) wrong |= sscanf(value, "%d%c", &n, &more) != 1 || n < 2 || n > 10000000;
        else if (!strcmp(name, "--steps")) wrong |= sscanf(value, "%d%c", &steps, &more) != 1 || steps < 0;
        else if (!strcmp(name, "--every")) wrong |= sscanf(value, "%d%c", &every, &more) != 1 || every < 1;
        else if (!strcmp(name, "--size")) wrong |= sscanf(value, "%dx%d%c", &wide, &high, &more) != 2 || wide < 1 || high < 1;
        else if (!strcmp(name, "--pictures")) wrong |= *(folder = value) == 0;
        else wrong = 1;
    }
    if (wrong) {
        if (rank == 0)
            fprintf(stderr, "usage: galaxies [--bodies 6000] [--steps 2000] [--every 10] [--size 1024x768] [--pictures FOLDER]\n");
        MPI_Finalize();
        return 2;
    }
    if (folder != NULL && rank == 0 && mkdir(folder, 0777) != 0 && errno != EEXIST) {
        fprintf(stderr, "error: %s: %s\n", folder, strerror(errno));
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    int *counts = memory(processes, sizeof *counts), *starts = memory(processes, sizeof *starts);
    for (int r = 0; r < processes; r++) {
        starts[r] = (int)((long long)n * r / processes);
        counts[r] = (int)((long long)n * (r + 1) / processes) - starts[r];
    }
    first = starts[rank], last = first + counts[rank];
    begin();
    attract();

    /* Processes are the parallelism here. */
    check(tercio_set_threads(1));
    MPI_Comm comm = MPI_COMM_WORLD;
    tercio_session *session = tercio_open_mpi(&comm);
    check(session == NULL);
    const double night[4] = {0.02, 0.03, 0.06, 1}, eye[3] = {0, -6.6, 4.2}, middle[3] = {0, 0, 0}, up[3] = {0, 0, 1};
    check(tercio_set_picture(session, (uint32_t)wide, (uint32_t)high, 0));
    check(tercio_set_background(session, night));
    check(tercio_set_camera(session, eye, middle, up, 35));
    uint32_t cores[2] = {add_ball(session, 1, 0.85, 0.4), add_ball(session, 0.6, 0.8, 1)};

    int pictures = 0;
    double before = energy();
    struct seconds all = {0, 0}, drawing = {0, 0}, writing = {0, 0}, started = now();
    for (int s = 1; s <= steps; s++) {
        step(counts, starts);
        if (s % every != 0) continue;
        struct seconds came = now();
        draw(session, cores);
        add_since(&drawing, came);
        pictures++;
        if (folder != NULL) {
            char path[4096];
            struct seconds drawn = now();
            snprintf(path, sizeof path, "%s/galaxies-%05d.png", folder, s);
            check(tercio_save(session, path));
            add_since(&writing, drawn);
        }
    }
    add_since(&all, started);
    report(all, drawing, writing);
    double after = energy();
    if (rank == 0) printf("energy: %.6f before, %.6f after\n", before, after);
    if (rank == 0) printf("%d steps of %d bodies in %d processes, %d pictures\n", steps, n, processes, pictures);
    check(tercio_close(session));
    MPI_Finalize();
    return 0;
}
