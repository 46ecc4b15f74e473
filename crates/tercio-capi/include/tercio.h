/*
 * tercio: draws polygon models without a GPU; here, what a program computes, while it computes it.
 *
 * Functions return 0, or another number if they failed; tercio_last_error has the reason then. Those that are called collective have
 * to be called by all processes of a session, in the same order and with the same values, except for arrays; the others have to be
 * called with the same values by all processes before the next collective one.
 *
 * Made by cargo xtask header. docs/in-situ.md explains how to use it.
 */

#ifndef TERCIO_H
#define TERCIO_H

#include <stddef.h>
#include <stdint.h>

/**
 * What one process draws with, together with the other processes of its session. It is used by one thread at a time; with MPI, by the
 * thread that may call MPI.
 */
typedef struct tercio_session tercio_session;

/**
 * Triangles in arrays of the program, which are read during the call only. Set unused fields to zero.
 */
typedef struct tercio_arrays {
  /**
   * Number of vertices.
   */
  size_t vertices;
  /**
   * x, y and z of each vertex in single precision; NULL if they are in double precision.
   */
  const float *positions_f32;
  /**
   * x, y and z of each vertex in double precision; NULL if they are in single precision.
   */
  const double *positions_f64;
  /**
   * Number of triangles.
   */
  size_t triangles;
  /**
   * Three vertex numbers for each triangle, the first vertex is 0; counter-clockwise seen from outside.
   */
  const uint32_t *corners;
  /**
   * x, y and z of the normal at each vertex, of any length; NULL to have normals made.
   */
  const float *normals;
  /**
   * Red, green, blue (sRGB) and alpha of each vertex; NULL for the colour of the part.
   */
  const uint8_t *colors;
} tercio_arrays;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The reason why the last function that failed on this thread did so; an empty string if none did. The text is valid until another
 * function fails.
 */
const char *tercio_last_error(void);

/**
 * The version of the library, as in "0.1.0".
 */
const char *tercio_version(void);

/**
 * Chooses how many threads draw, for all sessions of this process; 0 for as many as there are processors, shared with the other
 * processes of an MPI job on this machine, which is the default. Call it before the first session is opened. The picture does not
 * depend on it.
 */
int tercio_set_threads(uint32_t threads);

/**
 * Opens a session of this process alone; NULL if it failed.
 */
struct tercio_session *tercio_open(void);

/**
 * Opens a session of all processes of an MPI communicator; comm points to the MPI_Comm. Collective. The library uses a duplicate
 * of it, so that its messages and those of the program never meet; MPI is called by the thread that calls the functions of the
 * session, and by no other (MPI_THREAD_FUNNELED). NULL if it failed, also if the library was built without MPI.
 */
struct tercio_session *tercio_open_mpi(const void *comm);

/**
 * Ends a session, and frees it, also one of which a function failed. Collective: it waits for the other processes. Before
 * MPI_Finalize. Nothing is done with NULL.
 */
int tercio_close(struct tercio_session *session);

/**
 * Seconds after which a process that waits for another one fails; 0 to wait for ever, which is the default.
 */
int tercio_set_timeout(struct tercio_session *session, double seconds);

/**
 * How processes share a picture, which looks the same: "sort-last", the default, "sort-middle", "sort-first" or "sort-twice".
 */
int tercio_set_organisation(struct tercio_session *session, const char *name);

/**
 * Seconds that this process has spent in collective functions of the session so far, waiting for other processes included; not
 * writing of files. Negative for NULL.
 */
double tercio_seconds_spent(const struct tercio_session *session);

/**
 * Adds a part that stays until it is removed, and stores its number, 0 for the first one. Collective; each process passes the triangles
 * that it has, which may be none. Surfaces of several processes are joined where they have vertices at the same position. All
 * processes that have vertices pass normals, or none does, and the same for colours.
 */
int tercio_add(struct tercio_session *session,
               const struct tercio_arrays *arrays,
               uint32_t *part);

/**
 * Replaces the arrays of a part; transform and surface stay. Collective.
 */
int tercio_update(struct tercio_session *session, uint32_t part, const struct tercio_arrays *arrays);

/**
 * Removes a part; its number is not used again.
 */
int tercio_remove(struct tercio_session *session, uint32_t part);

/**
 * Adds triangles for the next picture only. Collective.
 */
int tercio_show(struct tercio_session *session, const struct tercio_arrays *arrays);

/**
 * Places a part: 16 numbers of an affine matrix in column-major order (as in OpenGL; the translation is numbers 12 to 14).
 */
int tercio_set_transform(struct tercio_session *session, uint32_t part, const double *matrix);

/**
 * The colour (sRGB, 0 to 1) of a part that has no colours of its own, and its opacity, 0 to 1.
 */
int tercio_set_surface(struct tercio_session *session, uint32_t part, const double *rgb, double opacity);

/**
 * Which axis points upwards for tercio_fit_camera: 'x', 'y', which is the default, or 'z'.
 */
int tercio_set_up_axis(struct tercio_session *session, char axis);

/**
 * Places the camera so that it sees all parts: degrees to the right of the front and above the horizon, and a zoom, 1 to fill the
 * picture. Collective. The camera stays until it is placed again; without a camera the first picture gets one that fits.
 */
int tercio_fit_camera(struct tercio_session *session, double azimuth, double elevation, double zoom);

/**
 * Places the camera: its position, the point in the middle of the picture, the direction that points upwards, and the full vertical
 * angle of view in degrees.
 */
int tercio_set_camera(struct tercio_session *session,
                      const double *eye,
                      const double *target,
                      const double *up,
                      double fov_degrees);

/**
 * The colour (sRGB) and alpha of the background, all 0 to 1.
 */
int tercio_set_background(struct tercio_session *session, const double *rgba);

/**
 * Width and height of the pictures in pixels, 1024 x 768 if they are not set, and the samples of each pixel: 1, 2, 4, 8 or 16; 0 for the
 * default.
 */
int tercio_set_picture(struct tercio_session *session,
                       uint32_t width,
                       uint32_t height,
                       uint32_t samples);

/**
 * Draws a picture of all parts, and of what is shown. Collective. Rank 0 of the communicator gets it.
 */
int tercio_render(struct tercio_session *session);

/**
 * Stores where the pixels of the last picture are: four bytes each (sRGB and alpha, not premultiplied), row by row, the upper left one
 * first, and width and height. They are valid until the next call with this session. On other ranks than rank 0, and before the
 * first picture, NULL and zeros are stored.
 */
int tercio_pixels(struct tercio_session *session,
                  const uint8_t **pixels,
                  uint32_t *width,
                  uint32_t *height);

/**
 * Writes the last picture, as PNG, PPM, WebP or JPEG by its extension; a file is replaced only when the new one is complete. On other ranks
 * than rank 0 nothing is done.
 */
int tercio_save(struct tercio_session *session,
                const char *path);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TERCIO_H */
