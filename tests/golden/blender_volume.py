# SPDX-License-Identifier: Apache-2.0
"""Runs inside Blender: opens a volume, prints its grid, its box, and its extinction summed over
space [m²], as seen in a picture where each voxel shines as much as it holds."""
import json
import math
import sys

import bpy

file, picture = sys.argv[sys.argv.index("--") + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.object.volume_import(filepath=file, align="WORLD", location=(0, 0, 0))
tree = bpy.context.object
tree.data.grids.load()
grids = [{"name": grid.name, "type": grid.data_type} for grid in tree.data.grids]
low = [min(corner[axis] for corner in tree.bound_box) for axis in range(3)]
high = [max(corner[axis] for corner in tree.bound_box) for axis in range(3)]

material = bpy.data.materials.new("extinction")
material.use_nodes = True
nodes, links = material.node_tree.nodes, material.node_tree.links
nodes.clear()
value = nodes.new("ShaderNodeAttribute")
value.attribute_name = "extinction"
shine = nodes.new("ShaderNodeEmission")
output = nodes.new("ShaderNodeOutputMaterial")
links.new(value.outputs["Fac"], shine.inputs["Strength"])
links.new(shine.outputs[0], output.inputs["Volume"])
tree.data.materials.append(material)

scene = bpy.context.scene
scene.world = bpy.data.worlds.new("dark")
scene.world.color = (0, 0, 0)
scene.render.engine = "CYCLES"
scene.cycles.samples = 16
scene.cycles.volume_step_rate = 0.3
scene.cycles.use_denoising = False
lens = bpy.data.cameras.new("level")
lens.type = "ORTHO"
lens.ortho_scale = 1.02 * max(high[0] - low[0], high[2] - low[2])
camera = bpy.data.objects.new("level", lens)
camera.location = ((low[0] + high[0]) / 2, low[1] - 5, (low[2] + high[2]) / 2)
camera.rotation_euler = (math.pi / 2, 0, 0)
scene.collection.objects.link(camera)
scene.camera = camera
scene.render.resolution_x = scene.render.resolution_y = 96
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = picture
bpy.ops.render.render(write_still=True)
pixels = list(bpy.data.images.load(picture).pixels)[0::4]
print("BLENDER " + json.dumps({"grids": grids, "low": low, "high": high,
                               "sum_m2": sum(pixels) / len(pixels) * lens.ortho_scale ** 2}))
