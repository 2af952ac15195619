"""``patrol calibrate``: fit a robot's settings to pictures and recordings."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import tomli_w
from numpy.typing import NDArray

from drivers.camera import Camera, wait_for_picture
from drivers.camera_source import CameraSettings
from drivers.p2os.model_choice import expected_model
from maps.image_size import image_size, jpeg_size
from maps.whole_file import write_whole
from robot_agent.config import AgentConfig, load_config
from robot_agent.perception.band_detector import BandDetector
from robot_agent.perception.color_settings import ColorModelSettings, ColorSettings
from robot_agent.perception.jpeg import decode_picture
from robot_agent.perception.silhouette import Silhouettes, body_corners
from tools.calibration.camera_calibration import fit_camera, pairs_of
from tools.calibration.color_calibration import (
    Box,
    CalibrationError,
    band_at,
    inside,
    learn_color,
    middle_of,
)
from tools.calibration.config_section import require_config, set_keys
from tools.calibration.drive import Drive, read_drive
from tools.calibration.ego_motion import laser_motions
from tools.calibration.motion_calibration import GeometryFit, fit_geometry
from tools.calibration.own_parts import own_sectors
from tools.calibration.teammate_calibration import learn_silhouette, standing_scans
from tools.calibration.teammate_picture import draw_silhouette
from tools.logs.recording import read_recording
from tools.logs.scan_log import read_scan_log
from tools.output_path import output_file
from tools.progress import progress_line

LIVE_PICTURES = 10
PICTURE_LIMIT_S = 10.0

_WANTED_WHEELS = 0.0015  # standard deviation of their scales: 0.3 % in 19 of 20 drives. Ours


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.epilog = (
        "examples:\n"
        "  patrol calibrate color --robot robot1.toml                 target before the lens\n"
        "  patrol calibrate color band*.png --at 160,118 --robot robot1.toml --mask mask.png\n"
        "  patrol calibrate camera RUN.mcap --robot robot1.toml\n"
        "  patrol calibrate teammate RUN.mcap --robot robot1.toml     it turns before this one\n"
        "  patrol calibrate laser DRIVE.mcap --robot robot1.toml      from patrol record --teleop\n"
        "  patrol calibrate odometry DRIVE.mcap --robot robot1.toml"
    )
    kinds = parser.add_subparsers(dest="what", metavar="WHAT", required=True)
    color = kinds.add_parser("color", help="learn the band's colour from pictures or the camera")
    color.add_argument("pictures", nargs="*", type=Path, metavar="PICTURE", help="none: the camera")
    color.add_argument("--box", metavar="LEFT,TOP,WIDTH,HEIGHT", help="where the band is, pixels")
    color.add_argument("--at", metavar="X,Y", help="a point on the band, pixels")
    color.add_argument(
        "--mask", type=output_file, metavar="PNG", help="show what is taken for the band"
    )
    camera = kinds.add_parser("camera", help="fit direction and focal length to a recording")
    camera.add_argument("recording", type=Path, metavar="REC.mcap")
    teammate = kinds.add_parser("teammate", help="learn what a teammate looks like in the laser")
    teammate.add_argument("recording", type=Path, metavar="RUN", help="recording or CARMEN log")
    teammate.add_argument("--picture", type=output_file, metavar="PNG", help="default: beside RUN")
    laser = kinds.add_parser("laser", help="find the laser's mount from a drive")
    laser.add_argument(
        "--ignore", action="store_true", help="write the proposed sectors of own parts as well"
    )
    odometry = kinds.add_parser("odometry", help="find wheel scales and track from a drive")
    for kind in (laser, odometry):
        kind.add_argument("drive", type=Path, metavar="DRIVE.mcap", help="or a CARMEN log")
    for kind in (color, camera, teammate, laser, odometry):
        kind.add_argument(
            "--robot", type=output_file, metavar="ROBOT.toml", help="file to write it into"
        )


def run(options: argparse.Namespace) -> int:
    """Calibrate, print the result as TOML and, with ``--robot``, write it to that file."""
    kinds = {
        "color": _color,
        "camera": _camera,
        "teammate": _teammate,
        "laser": _laser,
        "odometry": _odometry,
    }
    if options.robot is not None:
        require_config(options.robot)  # before the work that it would lose
    return kinds[options.what](options)


def _color(options: argparse.Namespace) -> int:
    config = load_config(options.robot) if options.robot else AgentConfig()
    pictures = (
        [_read(path) for path in options.pictures]
        if options.pictures
        else _live_pictures(config.camera)
    )
    masks = [_marked(picture, options.box, options.at) for picture in pictures]
    model = learn_color(list(zip(pictures, masks, strict=True)))
    print("[perception.color.band]")
    print(f"mean = {list(model.mean)}")
    print(f"covariance = {list(model.covariance)}")
    if options.mask:
        shown = mask_picture(pictures[0], config.camera, config.perception.color, model)
        write_whole(options.mask, cv2.imencode(".png", shown)[1].tobytes())
    if options.robot:
        values = {"mean": list(model.mean), "covariance": list(model.covariance)}
        set_keys(options.robot, "perception.color.band", values)
    return 0


def _read(path: Path) -> NDArray[np.uint8]:
    data = path.read_bytes()
    picture = decode_picture(data, jpeg_size(data) or image_size(data))
    if picture is None:
        raise CalibrationError(
            f"{path}: is no picture that can be read; give a PNG or JPEG of at most 4096 x 4096"
        )
    return picture


def _live_pictures(settings: CameraSettings) -> list[NDArray[np.uint8]]:
    if not settings.url:
        raise CalibrationError("no pictures and no camera: name files, or --robot with a [camera]")
    camera = Camera(settings)
    camera.start()
    pictures: list[NDArray[np.uint8]] = []
    number = 0
    try:
        while len(pictures) < LIVE_PICTURES:
            picture = wait_for_picture(camera, PICTURE_LIMIT_S, after=number)
            if picture is None:
                raise CalibrationError(camera.status.reason or f"{settings.url}: no pictures")
            number = picture.number
            pictures.append(picture.pixels)
    finally:
        camera.close()
    return pictures


def _marked(picture: NDArray[np.uint8], box: str | None, at: str | None) -> NDArray[np.bool_]:
    """Return the mask of a picture's pixels that belong to the band, (height, width)."""
    if at:
        x, y = _numbers(at, 2, "--at")
        return band_at(picture, x, y)
    return inside(picture, Box(*_numbers(box, 4, "--box")) if box else middle_of(picture))


def _numbers(text: str, count: int, option: str) -> list[int]:
    parts = text.split(",")
    if len(parts) != count or not all(part.strip().lstrip("-").isdecimal() for part in parts):
        raise CalibrationError(f"{option} {text}: give {count} whole numbers with commas between")
    return [int(part) for part in parts]


def mask_picture(
    picture: NDArray[np.uint8],
    camera: CameraSettings,
    color: ColorSettings,
    model: ColorModelSettings,
) -> NDArray[np.uint8]:
    """Return a BGR picture with the detector's mask of band pixels to its right."""
    detector = BandDetector(camera, msgspec.structs.replace(color, band=model))
    mask = cv2.cvtColor(detector.mask(picture), cv2.COLOR_GRAY2BGR)
    return np.hstack((picture, np.asarray(mask, dtype=np.uint8)))


def _camera(options: argparse.Namespace) -> int:
    recording = read_recording(options.recording)
    pairs, settings = pairs_of(recording)
    fit = fit_camera(pairs, settings)
    x, y, _ = settings.mount
    mount = [x, y, round(fit.theta, 5)]
    print("[camera]")
    print(f"mount = {mount}")
    print(f"focal_length = {fit.focal_length:.2f}")
    print(
        f"{fit.pairs} moments; {math.degrees(fit.theta):.2f} degrees to the left of ahead, "
        f"{fit.rms:.1f} pixels rms",
        file=sys.stderr,
    )
    if options.robot:
        set_keys(
            options.robot,
            "camera",
            {"mount": mount, "focal_length": round(fit.focal_length, 2)},
        )
    return 0


def _teammate(options: argparse.Namespace) -> int:
    config = load_config(options.robot) if options.robot else AgentConfig()
    so_far = config.perception.silhouettes
    scans = [
        (each.t, each.odometry, each.points()) for each in read_scan_log(options.recording).scans
    ]
    own = body_corners(expected_model(config.base).body)
    learned = learn_silhouette(standing_scans(scans), Silhouettes.admitted(so_far, own).shapes)
    picture = options.picture or options.recording.with_suffix(".teammate.png")
    draw_silhouette(learned, picture)
    silhouettes = [*so_far, [list(corner) for corner in learned.corners]]
    print("[perception]")
    print(f"silhouettes = {json.dumps(silhouettes)}")
    print(
        f"turned {math.degrees(learned.turned):.0f} degrees; its points lie within "
        f"{1000 * learned.rms:.0f} mm rms of it, of the best silhouette so far within "
        f"{1000 * learned.before:.0f} mm; look at {picture}",
        file=sys.stderr,
    )
    if options.robot:
        set_keys(options.robot, "perception", {"silhouettes": silhouettes})
    return 0


def _laser(options: argparse.Namespace) -> int:
    drive = read_drive(options.drive)
    fit = _fitted(drive)
    mount, upside_down = fit.geometry.mount, fit.geometry.upside_down
    x, y, theta = fit.sigma[:3]
    values: dict[str, Any] = {
        "mount": [round(mount.x, 4), round(mount.y, 4), round(mount.theta, 5)],
        "upside_down": upside_down,
    }
    sectors = own_sectors(drive.angles, drive.ranges)
    if options.ignore:
        values["ignore"] = [list(sector) for sector in sectors]
    _print_section("laser", values)
    print(
        f"theta {math.degrees(mount.theta):.2f} +- {math.degrees(theta):.2f} deg, place +- "
        f"{1000.0 * max(x, y):.0f} mm; {_residuals(fit)}",
        file=sys.stderr,
    )
    if sectors and not options.ignore:
        proposed = [list(sector) for sector in sectors]
        print(f"sees own parts: ignore = {proposed}; --ignore writes it", file=sys.stderr)
    if options.robot:
        set_keys(options.robot, "laser", values)
    return 0


def _odometry(options: argparse.Namespace) -> int:
    fit = _fitted(read_drive(options.drive))
    found = fit.geometry
    left, right, track = fit.sigma[3:]
    values = {
        "wheel_scale": [round(found.left, 4), round(found.right, 4)],
        "track": round(found.track, 4),
    }
    _print_section("base", values)
    print(
        f"wheels +- {100.0 * max(left, right):.2f} %, track +- {100.0 * track:.2f} %; "
        f"{_residuals(fit)}",
        file=sys.stderr,
    )
    if max(left, right) > _WANTED_WHEELS:
        print(
            f"for wheels +- {100.0 * _WANTED_WHEELS:g} % drive {fit.way_for(_WANTED_WHEELS):.0f} m "
            f"instead of {fit.way:.0f}",
            file=sys.stderr,
        )
    if options.robot:
        set_keys(options.robot, "base", values)
    return 0


def _fitted(drive: Drive) -> GeometryFit:
    with progress_line("scans", len(drive.odometry), "scans") as progress:
        motions = laser_motions(drive, progress)
    return fit_geometry(drive.odometry, motions, drive.configured)


def _residuals(fit: GeometryFit) -> str:
    return f"{fit.pairs} pairs of scans, off by {fit.before} before, {fit.after} after"


def _print_section(name: str, values: dict[str, Any]) -> None:
    print(f"[{name}]")
    print(tomli_w.dumps(values), end="")
