"""The site's zones as a scene of a Foxglove viewer: outlines and names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from shapely import Polygon

from maps.zone import Zone

if TYPE_CHECKING:
    from foxglove.messages import SceneUpdate

ZONES_TOPIC = "/zones"
_LINE_PIXELS = 2.0
_FONT_PIXELS = 14.0


def zones_scene(zones: Sequence[Zone]) -> SceneUpdate:
    """Return an entity for each zone, in the frame ``map``, that stays until it is replaced.

    Raises ImportError without Foxglove's SDK.
    """
    from foxglove import messages

    color = messages.Color(r=0.0, g=0.44, b=0.56, a=1.0)

    def entity(zone: Zone) -> messages.SceneEntity:
        outline = messages.LinePrimitive(
            type=messages.LinePrimitiveLineType.LineLoop,
            thickness=_LINE_PIXELS,
            scale_invariant=True,
            points=[messages.Point3(x=x, y=y, z=0.0) for x, y in zone.polygon],
            color=color,
        )
        inside = Polygon(zone.polygon).representative_point()
        name = messages.TextPrimitive(
            pose=messages.Pose(
                position=messages.Vector3(x=inside.x, y=inside.y, z=0.0),
                orientation=messages.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0),
            ),
            billboard=True,
            font_size=_FONT_PIXELS,
            scale_invariant=True,
            color=color,
            text=zone.name,
        )
        return messages.SceneEntity(frame_id="map", id=zone.name, lines=[outline], texts=[name])

    return messages.SceneUpdate(entities=[entity(zone) for zone in zones])
