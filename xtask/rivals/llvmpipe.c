/* llvmpipe, Mesa's software OpenGL, off screen (OSMesa): draws a model from each view and prints the times.
 *
 * OSMesa, not EGL: it needs no device and no window system, and a finished frame is in our memory without a further
 * copy. It gets its best input: one interleaved vertex buffer and one index buffer that stay in place,
 * lighting per vertex, and a malloc that keeps its memory. A frame ends when the picture is in our memory. */
#define _DEFAULT_SOURCE
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#include <GL/osmesa.h>

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

/* One directional light from the camera and a little ambient light, per vertex. */
static const char *const VERTEX_SHADER =
    "#version 120\n"
    "uniform mat4 clip_from_object;\n"
    "uniform vec3 to_light;\n"
    "attribute vec3 position, normal;\n"
    "varying vec4 color;\n"
    "void main() {\n"
    "    float light = 0.1 + 0.9 * abs(dot(normalize(normal), to_light));\n"
    "    color = vec4(vec3(0.578, 0.497, 0.392) * light, 1.0);\n"
    "    gl_Position = clip_from_object * vec4(position, 1.0);\n"
    "}\n";
static const char *const FRAGMENT_SHADER =
    "#version 120\n"
    "uniform float opacity;\n"
    "varying vec4 color;\n"
    "void main() { gl_FragColor = vec4(color.rgb, opacity); }\n";

enum { POSITION, NORMAL };

static GLuint compile(GLenum kind, const char *source) {
    GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &source, NULL);
    glCompileShader(shader);
    GLint done;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) die("a shader does not compile");
    return shader;
}

static GLuint link_program(void) {
    GLuint program = glCreateProgram();
    glAttachShader(program, compile(GL_VERTEX_SHADER, VERTEX_SHADER));
    glAttachShader(program, compile(GL_FRAGMENT_SHADER, FRAGMENT_SHADER));
    glBindAttribLocation(program, POSITION, "position");
    glBindAttribLocation(program, NORMAL, "normal");
    glLinkProgram(program);
    GLint done;
    glGetProgramiv(program, GL_LINK_STATUS, &done);
    if (!done) die("the shaders do not link");
    return program;
}

static void upload(const struct mesh *mesh) {
    GLuint buffers[2];
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)mesh->vertices * FLOATS_A_VERTEX * sizeof(float), mesh->attributes,
                 GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)mesh->triangles * 3 * sizeof(uint32_t), mesh->indices,
                 GL_STATIC_DRAW);
    for (GLuint a = POSITION; a <= NORMAL; a++) {
        glEnableVertexAttribArray(a);
        glVertexAttribPointer(a, 3, GL_FLOAT, GL_FALSE, FLOATS_A_VERTEX * sizeof(float),
                              (void *)(a * 3 * sizeof(float)));
    }
}

/* Makes everything be drawn with several samples per pixel, and returns the framebuffer of the samples; 0 if a pixel
 * has one: then it is drawn into our memory. */
static GLuint multisample(const struct options *options) {
    if (options->samples == 1) return 0;
    GLint most;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    if (options->samples > most) die("pixels have at most %d samples", most);
    GLuint framebuffer, planes[2];
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glGenRenderbuffers(2, planes);
    const GLenum formats[2] = {GL_RGBA8, GL_DEPTH_COMPONENT24}, places[2] = {GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT};
    int width = options->width, height = options->height;
    for (int i = 0; i < 2; i++) {
        glBindRenderbuffer(GL_RENDERBUFFER, planes[i]);
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, options->samples, formats[i], width, height);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, places[i], GL_RENDERBUFFER, planes[i]);
    }
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) die("no framebuffer of samples");
    GLint samples;
    glGetIntegerv(GL_SAMPLES, &samples);
    if (samples != options->samples) die("pixels have %d samples, not %d", samples, options->samples);
    glEnable(GL_MULTISAMPLE);
    return framebuffer;
}

/* Averages the samples of all pixels into our memory. */
static void resolve(GLuint framebuffer, const struct options *options) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    glBlitFramebuffer(0, 0, options->width, options->height, 0, 0, options->width, options->height, GL_COLOR_BUFFER_BIT,
                      GL_NEAREST);
}

/* Column-major, for a mesh moved by `offset`. */
static void clip_from_object(const struct view *v, const double offset[3], double aspect, const double depth[2],
                             GLfloat matrix[16]) {
    double n = depth[0], f = depth[1];
    double scale[4] = {1 / (v->tangent * aspect), 1 / v->tangent, (f + n) / (f - n), 1};
    double add[4] = {0, 0, -2 * f * n / (f - n), 0};
    const double *axis[4] = {v->right, v->up, v->forward, v->forward};
    for (int row = 0; row < 4; row++) {
        double shift = 0;
        for (int k = 0; k < 3; k++) {
            matrix[k * 4 + row] = axis[row][k] * scale[row];
            shift += axis[row][k] * (offset[k] - v->eye[k]);
        }
        matrix[12 + row] = shift * scale[row] + add[row];
    }
}

static void draw(const struct mesh *mesh, const struct views *views, const struct view *view,
                 const struct options *options, const double depth[2], const GLint uniforms[2], GLuint framebuffer) {
    double aspect = (double)options->width / options->height;
    if (framebuffer) glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUniform3f(uniforms[1], -view->forward[0], -view->forward[1], -view->forward[2]);
    for (int copy = 0; copy < views->copies; copy++) {
        GLfloat matrix[16];
        clip_from_object(view, views->copy[copy], aspect, depth, matrix);
        glUniformMatrix4fv(uniforms[0], 1, GL_FALSE, matrix);
        glDrawElements(GL_TRIANGLES, mesh->triangles * 3, GL_UNSIGNED_INT, NULL);
    }
    if (framebuffer) resolve(framebuffer, options);
    glFinish(); /* OSMesa copies the picture into our memory here. */
}

int main(int argc, char **argv) {
    struct options options = read_options(argc, argv);
    /* By default glibc returns large blocks to the system and allocates them again in every frame. */
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_TRIM_THRESHOLD, 2000 << 20);
    mallopt(M_TOP_PAD, 64 << 20);
    /* Rasterization threads, as many as Mesa's default for this number of cores: when the vertex stage, which runs
     * in this thread, is done, all cores rasterize. With 0 this thread rasterizes, too. */
    char threads[16];
    snprintf(threads, sizeof threads, "%d", options.threads > 1 ? options.threads : 0);
    setenv("LP_NUM_THREADS", threads, 0);
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);

    struct mesh mesh = read_mesh(options.model);
    struct views views = read_views(options.views);
    size_t pixels = (size_t)options.width * options.height;
    uint8_t *picture = malloc(pixels * 4);
    OSMesaContext context = OSMesaCreateContextExt(OSMESA_RGBA, 24, 0, 0, NULL);
    if (!context || !picture) die("no OSMesa context");
    if (!OSMesaMakeCurrent(context, picture, GL_UNSIGNED_BYTE, options.width, options.height))
        die("OSMesa makes no picture of %dx%d", options.width, options.height);
    GLint most[2];
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, most);
    if (options.width > most[0] || options.height > most[1]) die("pictures have at most %dx%d", most[0], most[1]);

    GLuint program = link_program();
    glUseProgram(program);
    GLint uniforms[2] = {glGetUniformLocation(program, "clip_from_object"), glGetUniformLocation(program, "to_light")};
    upload(&mesh);
    glUniform1f(glGetUniformLocation(program, "opacity"), options.opacity);
    GLuint framebuffer = multisample(&options);
    if (options.opacity < 1) {
        /* Every layer, in the order of the file: not the right picture, but the least that blending can take. */
        glEnable(GL_BLEND);
        glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    } else {
        glEnable(GL_DEPTH_TEST);
    }
    if (options.cull) glEnable(GL_CULL_FACE);
    glClearColor(0, 0, 0, 0);

    struct frames frames = new_frames(views.count);
    /* The first frame, which compiles the shaders, is drawn twice. */
    for (int i = -1; i < views.count; i++) {
        int n = i < 0 ? 0 : i;
        const struct view *view = views.view + n;
        double depth[2];
        depth_range(&mesh, &views, view, depth);
        double begin = milliseconds();
        draw(&mesh, &views, view, &options, depth, uniforms, framebuffer);
        frames.milliseconds[n] = milliseconds() - begin;
        frames.pixels[n] = count_pixels(picture, pixels);
    }
    GLenum error = glGetError();
    if (error) die("OpenGL error 0x%x", error);
    if (options.picture) write_picture(options.picture, picture, options.width, options.height, true);
    char facts[512];
    snprintf(facts, sizeof facts, "\"version\": \"%s, %s\", \"triangles\": %u, \"fill_threads\": \"%s\"",
             glGetString(GL_VERSION), glGetString(GL_RENDERER), mesh.triangles, getenv("LP_NUM_THREADS"));
    report(&frames, views.count, facts);
    OSMesaDestroyContext(context);
    return 0;
}
