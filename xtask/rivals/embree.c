/* Embree, a ray tracer: draws a model from each view with packets of 16 rays and prints the times, that of
 * building the tree separately. A packet is 4x4 pixels; threads take tiles of 64x64 pixels from a common counter. */
#define _POSIX_C_SOURCE 200809L
#include <embree3/rtcore.h>

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

enum { PACKET = 16, EDGE = 4, TILE = 64 };

/* One frame, shared by all threads. */
struct job {
    RTCScene scene;
    const struct mesh *mesh;
    const struct view *view;
    int width, height;
    uint8_t *picture;
    atomic_int next_tile;
};

static void on_error(void *user, enum RTCError code, const char *message) {
    (void)user;
    die("Embree error %d: %s", code, message);
}

static RTCScene build_tree(RTCDevice device, const struct mesh *mesh) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->attributes, 0,
                               FLOATS_A_VERTEX * sizeof(float), mesh->vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->indices, 0,
                               3 * sizeof(uint32_t), mesh->triangles);
    rtcCommitGeometry(geometry);
    RTCScene scene = rtcNewScene(device);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    return scene;
}

/* Rays through the centres of 4x4 pixels; those outside the picture are masked. */
static void aim(const struct job *job, int x0, int y0, struct RTCRayHit16 *rays, int *valid) {
    const struct view *v = job->view;
    double pixel = 2 * v->tangent / job->height;
    for (int i = 0; i < PACKET; i++) {
        int x = x0 + i % EDGE, y = y0 + i / EDGE;
        valid[i] = x < job->width && y < job->height ? -1 : 0;
        float across = (float)((x + 0.5 - 0.5 * job->width) * pixel);
        float down = (float)((y + 0.5 - 0.5 * job->height) * pixel);
        rays->ray.org_x[i] = (float)v->eye[0];
        rays->ray.org_y[i] = (float)v->eye[1];
        rays->ray.org_z[i] = (float)v->eye[2];
        rays->ray.dir_x[i] = (float)v->forward[0] + (float)v->right[0] * across - (float)v->up[0] * down;
        rays->ray.dir_y[i] = (float)v->forward[1] + (float)v->right[1] * across - (float)v->up[1] * down;
        rays->ray.dir_z[i] = (float)v->forward[2] + (float)v->right[2] * across - (float)v->up[2] * down;
        rays->ray.tnear[i] = 0;
        rays->ray.tfar[i] = INFINITY;
        rays->ray.time[i] = 0;
        rays->ray.mask[i] = ~0u;
        rays->ray.flags[i] = 0;
        rays->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        rays->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
}

/* Colour at the hit of a ray: the interpolated normal under one light from the camera. */
static void shade(const struct job *job, const struct RTCHit16 *hit, int i, uint8_t *rgba) {
    static const float BASE[3] = {0.578f, 0.497f, 0.392f};
    const uint32_t *corners = job->mesh->indices + (size_t)hit->primID[i] * 3;
    const float weights[3] = {1 - hit->u[i] - hit->v[i], hit->u[i], hit->v[i]};
    float normal[3] = {0, 0, 0}, facing = 0, square = 0;
    for (int c = 0; c < 3; c++) {
        const float *n = job->mesh->attributes + (size_t)corners[c] * FLOATS_A_VERTEX + 3;
        for (int k = 0; k < 3; k++) normal[k] += n[k] * weights[c];
    }
    for (int k = 0; k < 3; k++) facing += normal[k] * (float)job->view->forward[k], square += normal[k] * normal[k];
    float light = 0.1f + 0.9f * fabsf(facing) / sqrtf(square + 1e-30f);
    for (int k = 0; k < 3; k++) rgba[k] = (uint8_t)(BASE[k] * light * 255 + 0.5f);
    rgba[3] = 255;
}

static void *draw_tiles(void *argument) {
    struct job *job = argument;
    int across = (job->width + TILE - 1) / TILE, down = (job->height + TILE - 1) / TILE;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    struct RTCRayHit16 rays;
    _Alignas(64) int valid[PACKET];
    for (int tile; (tile = atomic_fetch_add(&job->next_tile, 1)) < across * down;) {
        int left = tile % across * TILE, top = tile / across * TILE;
        for (int block = 0; block < TILE * TILE / PACKET; block++) {
            int x0 = left + block % (TILE / EDGE) * EDGE, y0 = top + block / (TILE / EDGE) * EDGE;
            if (x0 >= job->width || y0 >= job->height) continue;
            aim(job, x0, y0, &rays, valid);
            rtcIntersect16(valid, job->scene, &context, &rays);
            for (int i = 0; i < PACKET; i++) {
                if (!valid[i]) continue;
                uint8_t *rgba = job->picture + ((size_t)(y0 + i / EDGE) * job->width + x0 + i % EDGE) * 4;
                if (rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) memset(rgba, 0, 4);
                else shade(job, &rays.hit, i, rgba);
            }
        }
    }
    return NULL;
}

static void draw(struct job *job, int threads) {
    pthread_t helpers[256];
    job->next_tile = 0;
    for (int t = 1; t < threads; t++)
        if (pthread_create(helpers + t, NULL, draw_tiles, job)) die("no thread");
    draw_tiles(job);
    for (int t = 1; t < threads; t++) pthread_join(helpers[t], NULL);
}

int main(int argc, char **argv) {
    struct options options = read_options(argc, argv);
    if (options.cull) die("rays do not cull");
    if (options.threads > 256) die("at most 256 threads");
    struct mesh mesh = read_mesh(options.model);
    struct views views = read_views(options.views);
    if (views.copies != 1 || views.copy[0][0] != 0 || views.copy[0][1] != 0 || views.copy[0][2] != 0)
        die("no copies here");

    char settings[64];
    snprintf(settings, sizeof settings, "threads=%d", options.threads);
    RTCDevice device = rtcNewDevice(settings);
    if (!device) die("no Embree device");
    rtcSetDeviceErrorFunction(device, on_error, NULL);
    double begin = milliseconds();
    RTCScene scene = build_tree(device, &mesh);
    double build = milliseconds() - begin;

    size_t pixels = (size_t)options.width * options.height;
    struct job job = {.scene = scene, .mesh = &mesh, .width = options.width, .height = options.height};
    job.picture = malloc(pixels * 4);
    if (!job.picture) die("no memory for the picture");
    struct frames frames = new_frames(views.count);
    /* The first frame, which touches the picture's memory, is drawn twice. */
    for (int i = -1; i < views.count; i++) {
        int n = i < 0 ? 0 : i;
        job.view = views.view + n;
        begin = milliseconds();
        draw(&job, options.threads);
        frames.milliseconds[n] = milliseconds() - begin;
        frames.pixels[n] = count_pixels(job.picture, pixels);
    }
    if (options.picture) write_picture(options.picture, job.picture, options.width, options.height, false);
    char facts[256];
    snprintf(facts, sizeof facts, "\"version\": \"%s\", \"triangles\": %u, \"build_ms\": %.1f, \"native_packets\": %s",
             RTC_VERSION_STRING, mesh.triangles, build,
             rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) ? "true" : "false");
    report(&frames, views.count, facts);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return 0;
}
