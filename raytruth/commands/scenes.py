"""List the scenes that come with raytruth, check scene files, or print the format's JSON Schema.

examples:
  raytruth scenes                       all shipped scenes
  raytruth scenes my-scene.json         is this file a scene? what is in it?
  raytruth scenes --schema              the JSON Schema of scene files
  raytruth scenes --show figure-07-torus > mine.json    a scene file to start from
"""

from __future__ import annotations

import json

from raytruth.reference_tracer.text import hanging


def add_arguments(parser):
    parser.add_argument("scene", nargs="*", help="names of shipped scenes or paths of scene files (default: all shipped)")
    parser.add_argument("--json", action="store_true", help="print a JSON list for programs")
    parser.add_argument("--schema", action="store_true", help="print the JSON Schema of the scene format")
    parser.add_argument("--show", metavar="SCENE", help="print one scene in full, defaults included")


def run(arguments) -> int:
    from raytruth.reference_tracer.scene import library
    from raytruth.reference_tracer.scene.model import json_schema

    if arguments.schema:
        print(json.dumps(json_schema(), indent=1, ensure_ascii=False))
        return 0
    if arguments.show:
        print(library.find(arguments.show).model_dump_json(indent=1, by_alias=True, exclude_none=True))
        return 0
    scenes = [library.find(name) for name in arguments.scene or (*library.names(), *library.effects())]
    rows = [{"name": s.name, "title": s.title, "figure": s.figure, "width": s.camera.width, "height": s.camera.height,
             "objects": len(s.objects), "lights": len(s.lights), "samples": s.tracing.samples,
             "surfaces": sorted({o.surface.type for o in s.objects}), "hash": s.hash} for s in scenes]
    if arguments.json:
        print(json.dumps(rows, indent=1))
        return 0
    width = max(len(r["name"]) for r in rows)
    for r in rows:
        objects = f"{r['objects']} object" + "s" * (r["objects"] != 1)
        print(hanging(f"{r['name']:<{width}}  {r['width']:>5} x {r['height']:<5} {objects:<10}", r["title"]))
    return 0
