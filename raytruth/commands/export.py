"""Write a scene, or the mesh of an object, as a file of another program.

examples:
  raytruth export figure-07-torus -o torus.glb --cells 128     a mesh; also .ply, .obj and .stl
  raytruth export figure-17-scene1 -o floor.ply --object 0     of one object, by its name or number
  raytruth export figure-17-scene1 -o scene.xml                for Mitsuba 3, with PLY files beside it: mitsuba scene.xml
  raytruth export figure-17-scene1 -o scene.pov                for POV-Ray 3.7; its first lines say how to render it
  raytruth export figure-17-scene1 -o scene.txt                plain text for ports of the document

The ending says what is written. Printed is how far meshes are from the surfaces at most, what was cut off of surfaces
without an end, and what the other program shows otherwise.
"""

from __future__ import annotations

import json

from ..arguments import sentence, whole


def add_arguments(parser):
    parser.add_argument("scene", help="name of a shipped scene or path of a scene file")
    parser.add_argument("-o", "--output", required=True, metavar="FILE",
                        help="ends in .ply, .obj, .stl, .glb, .xml, .pov or .txt")
    parser.add_argument("--object", metavar="NAME", help="one object's mesh, by its name or its number from 0 (default: all)")
    parser.add_argument("--cells", metavar="N", type=whole(4, 4096), default=256,
                        help="cells of a mesh along the longest side of its object (default 256)")
    parser.add_argument("--json", action="store_true", help="print what was written as JSON")


def run(arguments) -> int:
    from raytruth.comparisons.progress import Progress
    from raytruth.converters.export import export
    from raytruth.reference_tracer.scene.library import find

    scene = find(arguments.scene)
    with Progress(1.0, label=f"{scene.name}: exporting"):
        done = export(scene, arguments.output, arguments.object, arguments.cells)
    if arguments.json:
        print(json.dumps({"files": [str(file) for file in done.files], "told": done.told}))
    else:
        for line in (*map(str, done.files), *done.told):
            print(sentence(line))
    return 0
