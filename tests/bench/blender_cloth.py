"""Lets Blender's cloth fall over a rising mold, for comparison with forming: one line of JSON.

    blender --background --factory-startup --python tests/bench/blender_cloth.py -- MOLD.stl CELLS

The sheet of 300 mm has CELLS x CELLS cells and is held at its rim; the mold rises into it over 100 frames, and 20 follow.
Quality and collisions are Blender's defaults. Cloth is a net of springs that slips: its shape is no print.
"""
import json
import sys
import time

import bpy

MM = 0.1  # units of Blender in one millimetre: its collisions keep a distance of at least a thousandth of a unit
SHEET_MM, RISE, REST = 300, 100, 20


def main(mold, cells):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_mesh.stl(filepath=mold, global_scale=MM)
    head = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = head
    bpy.ops.object.modifier_add(type="COLLISION")
    head.collision.thickness_outer = 0.2 * MM
    top = max(v.co.z for v in head.data.vertices)
    for height, frame in (-top - MM, 1), (0, RISE):
        head.location.z = height
        head.keyframe_insert("location", frame=frame)
    for curve in head.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"

    bpy.ops.mesh.primitive_grid_add(x_subdivisions=cells, y_subdivisions=cells, size=SHEET_MM * MM)
    sheet = bpy.context.object
    half = 0.4999 * SHEET_MM * MM
    rim = sheet.vertex_groups.new(name="rim")
    rim.add([v.index for v in sheet.data.vertices if max(abs(v.co.x), abs(v.co.y)) > half], 1, "ADD")
    bpy.ops.object.modifier_add(type="CLOTH")
    cloth = sheet.modifiers[-1]
    cloth.settings.vertex_group_mass = rim.name
    cloth.collision_settings.distance_min = 0.2 * MM
    cloth.point_cache.frame_end = RISE + REST
    bpy.context.scene.frame_end = RISE + REST

    wall, cpu = time.monotonic(), time.process_time()
    for frame in range(1, RISE + REST + 1):
        bpy.context.scene.frame_set(frame)
    wall, cpu = time.monotonic() - wall, time.process_time() - cpu
    formed = sheet.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    highest = max(v.co.z for v in formed.vertices)
    print(json.dumps({"cells": cells, "wall": wall, "cpu": cpu, "highest_mm": highest / MM, "mold_mm": top / MM}))


main(sys.argv[-2], int(sys.argv[-1]))
