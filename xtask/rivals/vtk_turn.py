"""VTK over Mesa's llvmpipe, off screen (OSMesa): draws a model from each view and prints the times.

The model stays in place between frames; VTK lights every pixel in its default look, one light at the camera. Surfaces
that are not opaque are drawn by depth peeling, its way to draw them in the right order, until nothing is left. A frame
ends when its RGBA bytes are in our memory.
"""

import argparse
import json
import math
import os
import time

parser = argparse.ArgumentParser()
parser.add_argument("model")
parser.add_argument("views")
parser.add_argument("--size", default="1024x1024")
parser.add_argument("--threads", default=2, type=int)
parser.add_argument("--samples", default=1, type=int)
parser.add_argument("--opacity", default=1.0, type=float)
parser.add_argument("--picture", help="a PPM of the last view")
options = parser.parse_args()
width, height = map(int, options.size.split("x"))

# Before the libraries are loaded. Threads of llvmpipe as in llvmpipe.c.
os.environ["LP_NUM_THREADS"] = str(options.threads if options.threads > 1 else 0)
os.environ.setdefault("GALLIUM_DRIVER", "llvmpipe")
os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkOSOpenGLRenderWindow")

import vtk  # noqa: E402
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402


def read_views(path):
    """The cameras: eye, right, up, forward, tangent of half the vertical angle."""
    views = []
    with open(path, encoding="ascii") as lines:
        for line in lines:
            kind, *numbers = line.split()
            numbers = [float(number) for number in numbers]
            if kind == "view":
                views.append((numbers[0:3], numbers[6:9], numbers[9:12], numbers[12]))
            elif kind != "copy" or any(numbers):
                raise SystemExit(f'error: {path}: "{kind}" is not understood')
    return views


reader = vtk.vtkPLYReader()
reader.SetFileName(options.model)
reader.Update()
mesh = reader.GetOutput()
if mesh.GetPointData().GetNormals() is None:
    raise SystemExit(f"error: {options.model}: no normals")
mapper = vtk.vtkPolyDataMapper()
mapper.SetInputData(mesh)
mapper.StaticOn()
actor = vtk.vtkActor()
actor.SetMapper(mapper)
actor.GetProperty().SetColor(0.578, 0.497, 0.392)
actor.GetProperty().SetOpacity(options.opacity)
renderer = vtk.vtkRenderer()
renderer.AddActor(actor)
renderer.SetBackground(0.0, 0.0, 0.0)
renderer.SetBackgroundAlpha(0.0)
window = vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetAlphaBitPlanes(1)
window.SetMultiSamples(options.samples if options.samples > 1 else 0)
window.SetSize(width, height)
window.AddRenderer(renderer)
if options.opacity < 1.0:
    renderer.SetUseDepthPeeling(1)
    renderer.SetMaximumNumberOfPeels(1000)
    renderer.SetOcclusionRatio(0.0)

pixels = vtk.vtkUnsignedCharArray()


def draw(view):
    """Draws a view and returns milliseconds and the number of pixels that show the model."""
    eye, up, forward, tangent = view
    camera = renderer.GetActiveCamera()
    camera.SetPosition(eye)
    camera.SetFocalPoint([e + f for e, f in zip(eye, forward)])
    camera.SetViewUp(up)
    camera.SetViewAngle(2.0 * math.degrees(math.atan(tangent)))
    renderer.ResetCameraClippingRange()
    begin = time.perf_counter()
    window.Render()
    window.GetRGBACharPixelData(0, 0, width - 1, height - 1, 0, pixels)
    milliseconds = (time.perf_counter() - begin) * 1e3
    alpha = vtk_to_numpy(pixels).reshape(height, width, 4)[:, :, 3]
    return {"milliseconds": milliseconds, "pixels": int((alpha != 0).sum())}


views = read_views(options.views)
# The first frame, which compiles the shaders, is drawn twice.
draw(views[0])
frames = [draw(view) for view in views]
if options.picture:
    rows = vtk_to_numpy(pixels).reshape(height, width, 4)[::-1, :, :3]
    with open(options.picture, "wb") as file:
        file.write(b"P6\n%d %d\n255\n" % (width, height) + rows.tobytes())
capabilities = {
    key.strip(): value.strip()
    for key, _, value in (line.partition(":") for line in window.ReportCapabilities().splitlines())
}
facts = {
    "version": f'VTK {vtk.vtkVersion.GetVTKVersion()}, {capabilities.get("OpenGL renderer string", "unknown")}',
    "triangles": mesh.GetNumberOfPolys(),
    "window": window.GetClassName(),
    "samples": window.GetMultiSamples(),
}
print(json.dumps({**facts, "views": frames}))
