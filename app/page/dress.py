"""How viser's page looks at first: the scene with its camera, and the panel that all share."""

from typing import Final

import numpy as np
import viser

from app.page.scene.board import FLAT_CAMERA, FLAT_TARGET

_FOV_RADIANS: Final = np.pi / 3
_PANEL_WIDTH: Final = 330.0


def dress(server: viser.ViserServer) -> None:
    """Set all that is the same for every browser of a lab."""
    server.scene.set_up_direction("+z")
    server.scene.configure_default_lights(enabled=False)
    server.scene.world_axes.visible = False
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(_PANEL_WIDTH)
    camera = server.initial_camera
    camera.up = (0.0, 1.0, 0.0)
    camera.look_at = FLAT_TARGET
    camera.position = FLAT_CAMERA
    camera.fov = _FOV_RADIANS
