"""An OpenGL context without a window, and a picture to draw into."""

import ctypes
import os
from typing import Any

import numpy as np

DEVICE = 0x313F
"""EGL_PLATFORM_DEVICE_EXT"""
SAMPLES = 4
"""Per pixel: without, edges crawl."""


class NoOpenGL(Exception):
    """This machine cannot draw; what was recorded is unharmed."""


def open_context() -> Any:
    """Open a context on the first device that works, and make it current; return the module of OpenGL's functions.

    Raises:
        NoOpenGL: if there is none.
    """
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    os.environ.pop("DISPLAY", None)
    try:
        import OpenGL
        from OpenGL import EGL

        _make_current(EGL)
        # Not before EGL is imported, which cannot do without. Looking for errors after every call costs more than it.
        OpenGL.ERROR_CHECKING = OpenGL.ERROR_LOGGING = False
        from OpenGL import GL
    except Exception as error:  # missing libraries, drivers that refuse: each raises its own
        raise NoOpenGL(f"cannot draw: {str(error) or type(error).__name__}") from error
    return GL


def _make_current(egl: Any) -> None:
    error = None
    for display in _displays(egl):
        try:
            major, minor, count = ctypes.c_long(), ctypes.c_long(), ctypes.c_long()
            if not egl.eglInitialize(display, major, minor):
                continue
            wanted = (egl.EGL_SURFACE_TYPE, egl.EGL_PBUFFER_BIT, egl.EGL_RENDERABLE_TYPE, egl.EGL_OPENGL_BIT)
            configs = (egl.EGLConfig * 1)()
            egl.eglChooseConfig(display, _ints(*wanted, egl.EGL_NONE), configs, 1, count)
            egl.eglBindAPI(egl.EGL_OPENGL_API)
            version = (egl.EGL_CONTEXT_MAJOR_VERSION, 3, egl.EGL_CONTEXT_MINOR_VERSION, 3)
            profile = (egl.EGL_CONTEXT_OPENGL_PROFILE_MASK, egl.EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT)
            attributes = _ints(*version, *profile, egl.EGL_NONE)
            context = egl.eglCreateContext(display, configs[0], egl.EGL_NO_CONTEXT, attributes)
            if egl.eglMakeCurrent(display, egl.EGL_NO_SURFACE, egl.EGL_NO_SURFACE, context):
                return
        except Exception as failure:
            error = failure
    raise error or NoOpenGL("no device of EGL works")


def _displays(egl: Any) -> list[Any]:
    """The display of every device that EGL knows: a machine may have a card without a driver beside one that works."""
    query = egl.eglGetProcAddress("eglQueryDevicesEXT")
    display = egl.eglGetProcAddress("eglGetPlatformDisplayEXT")
    if not query or not display:
        return [egl.eglGetDisplay(egl.EGL_DEFAULT_DISPLAY)]
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)(query)
    display = ctypes.CFUNCTYPE(egl.EGLDisplay, ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p)(display)
    count = ctypes.c_int()
    query(0, None, ctypes.byref(count))
    devices = (ctypes.c_void_p * max(count.value, 1))()
    query(count.value, devices, ctypes.byref(count))
    return [display(DEVICE, device, None) for device in devices[: count.value]]


def _ints(*values: int) -> Any:
    return (ctypes.c_int * len(values))(*values)


class Canvas:
    """A picture of a fixed size, with several samples per pixel while it is drawn."""

    def __init__(self, gl: Any, width: int, height: int) -> None:
        self._gl, self.width, self.height = gl, width, height
        self._many, self._one = gl.glGenFramebuffers(2)
        self._buffers = gl.glGenRenderbuffers(3)
        samples = min(int(gl.glGetIntegerv(gl.GL_MAX_SAMPLES)), SAMPLES)
        for buffer, kind, place in (
            (self._buffers[0], gl.GL_RGBA8, gl.GL_COLOR_ATTACHMENT0),
            (self._buffers[1], gl.GL_DEPTH_COMPONENT24, gl.GL_DEPTH_ATTACHMENT),
        ):
            gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, self._many)
            gl.glBindRenderbuffer(gl.GL_RENDERBUFFER, buffer)
            gl.glRenderbufferStorageMultisample(gl.GL_RENDERBUFFER, samples, kind, width, height)
            gl.glFramebufferRenderbuffer(gl.GL_FRAMEBUFFER, place, gl.GL_RENDERBUFFER, buffer)
        gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, self._one)
        gl.glBindRenderbuffer(gl.GL_RENDERBUFFER, self._buffers[2])
        gl.glRenderbufferStorage(gl.GL_RENDERBUFFER, gl.GL_RGBA8, width, height)
        gl.glFramebufferRenderbuffer(gl.GL_FRAMEBUFFER, gl.GL_COLOR_ATTACHMENT0, gl.GL_RENDERBUFFER, self._buffers[2])
        self._pixels = np.empty((height, width, 4), np.uint8)

    def clear(self, color: tuple[float, ...]) -> None:
        """Begin a picture."""
        gl = self._gl
        gl.glBindFramebuffer(gl.GL_FRAMEBUFFER, self._many)
        gl.glViewport(0, 0, self.width, self.height)
        gl.glClearColor(*color[:3], 1.0)
        gl.glClear(gl.GL_COLOR_BUFFER_BIT | gl.GL_DEPTH_BUFFER_BIT)

    def read(self) -> np.ndarray:
        """Return the picture, shape (height, width, 4), uint8, from the top; valid until the next."""
        gl, size = self._gl, (0, 0, self.width, self.height)
        gl.glBindFramebuffer(gl.GL_READ_FRAMEBUFFER, self._many)
        gl.glBindFramebuffer(gl.GL_DRAW_FRAMEBUFFER, self._one)
        gl.glBlitFramebuffer(*size, *size, gl.GL_COLOR_BUFFER_BIT, gl.GL_NEAREST)
        gl.glBindFramebuffer(gl.GL_READ_FRAMEBUFFER, self._one)
        gl.glReadPixels(*size, gl.GL_RGBA, gl.GL_UNSIGNED_BYTE, self._pixels)
        return self._pixels[::-1]

    def delete(self) -> None:
        """Free what it holds."""
        self._gl.glDeleteFramebuffers(2, [self._many, self._one])
        self._gl.glDeleteRenderbuffers(3, self._buffers)
