/* A GL context without a window, for tests and the tool: EGL surfaceless (Mesa), 3.3 core or ES 3.0. */
#ifndef GL_CONTEXT_H
#define GL_CONTEXT_H

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <stdio.h>
#include <string.h>

typedef struct gl_context {
    EGLDisplay display;
    EGLContext context;
} gl_context;

/* 1 if it is current now. */
static int gl_context_open(gl_context *c, int es)
{
    static const EGLint gl_attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3,
                                           EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    static const EGLint es_attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display = (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    EGLConfig config = NULL;
    EGLint count = 0;
    EGLint attributes[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, 0, EGL_NONE};
    memset(c, 0, sizeof *c);
    attributes[3] = es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT;
    c->display = get_display != NULL ? get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL) : EGL_NO_DISPLAY;
    if (c->display == EGL_NO_DISPLAY) c->display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
    if (c->display == EGL_NO_DISPLAY || !eglInitialize(c->display, NULL, NULL)) return 0;
    if (!eglBindAPI(es ? EGL_OPENGL_ES_API : EGL_OPENGL_API)) return 0;
    if (!eglChooseConfig(c->display, attributes, &config, 1, &count) || count < 1) config = NULL;
    c->context = eglCreateContext(c->display, config, EGL_NO_CONTEXT, es ? es_attributes : gl_attributes);
    if (c->context == EGL_NO_CONTEXT) return 0;
    return eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, c->context) == EGL_TRUE;
}

static void gl_context_close(gl_context *c)
{
    if (c->display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (c->context != EGL_NO_CONTEXT) eglDestroyContext(c->display, c->context);
    eglTerminate(c->display);
}

#endif
