"""Pictures of a case before it is run: made with arrays alone, without the engine and without OpenGL.

`stage` puts everything where it starts, `raster` turns triangles into pixels, `layout` makes the page that
`text2sim show` writes, `portrait` the pictures of the gallery, and `views` says what a camera sees.
"""
