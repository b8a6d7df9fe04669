"""Pictures of a case before it is run, drawn with numpy, without the engine and without OpenGL.

`stage` collects the triangles of a case at its start, `raster` turns triangles into pixels, `layout` makes the page of
`text2sim show`, `portrait` the pictures of the gallery, and `views` has the views of a case's cameras.
"""
