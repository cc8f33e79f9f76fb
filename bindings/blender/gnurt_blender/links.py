# SPDX-License-Identifier: GPL-3.0-or-later
"""Light links: the objects that a light reaches, and those that cast its shadows, by collections of Blender.

Lights with links are lights of the scene or shapes that shine, whose instances have the names of their objects.
"""

FIELDS = {"receiver_collection": "link", "blocker_collection": "shadow_link"}


def are_there(found):
    """Whether an object has links as a light."""
    own = getattr(found, "light_linking", None)
    return own is not None and any(getattr(own, name) is not None for name in FIELDS)


def members(collection):
    """Names of the objects that a collection includes, and of those that it excludes."""
    included, excluded = set(), set()
    for each, entry in zip(collection.objects, collection.collection_objects):
        (included if entry.light_linking.link_state == "INCLUDE" else excluded).add(each.name)
    for child, entry in zip(collection.children, collection.collection_children):
        names = {each.name for each in child.all_objects}
        (included if entry.light_linking.link_state == "INCLUDE" else excluded).update(names)
    return included - excluded, excluded


def put(export):
    """Links all lights of a scene, after all objects are in it."""
    there = {found.name for found, *_ in export.objects.values()} | {found.name for found in export.linked}
    for found in export.linked:
        for name, field in FIELDS.items():
            collection = getattr(found.light_linking, name)
            if collection is None:
                continue
            included, excluded = (sorted(names & there) for names in members(collection))
            if any("," in each or "=" in each for each in (*included, *excluded, found.name)):
                export.warn(f"light '{found.name}': light links of names with commas are not shown")
                continue
            # A collection of exclusions leaves all others.
            value = ",".join(included) or "none"
            if not included and excluded:
                value = "^" + ",".join(excluded)
            for number in export.linked_lights.get(found.name, []):
                export.scene.set(f"lights.{number}.{field}={value}")
            try:
                export.scene.set(f"instances.{found.name}.{field}={value}")
            except ValueError:
                # A light that is dark and not seen is not in the scene.
                pass
