#!/usr/bin/env python3
"""Writes the bags of this folder with other people's writers: one little drive in every format.

    pip install rosbags==0.11.0 mcap==1.6.0 mcap-ros1-support==0.9.0 numpy==2.4.6 pillow==13.0.0 zstandard==0.25.0
    python make.py [FOLDER [SECONDS BEAMS PIXELS]]

The drive: 70 cm along a curve in 1.8 s, a scan of 16 beams every 0.3 s, odometry and tf at 5 Hz that drift by 2 %, tf map → odom
that corrects them, a sonar at 5 Hz, a picture a second, and messages that no recording needs. A longer drive with more
beams is for measuring.
"""

import contextlib
import io
import math
import shutil
import sqlite3
import sys
from pathlib import Path

import numpy as np
from PIL import Image
from mcap.writer import CompressionType, Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

FOLDER = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 1.8
BEAMS = int(sys.argv[3]) if len(sys.argv) > 3 else 16
PIXELS = int(sys.argv[4]) if len(sys.argv) > 4 else 16
START_NS = 1_700_000_000_000_000_000
LASER_DELAY_NS = 40_000_000  # a message is written down so long after what it tells of

STORE1 = get_typestore(Stores.ROS1_NOETIC)
STORE1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
STORE2 = get_typestore(Stores.ROS2_HUMBLE)


def pose_at(t):
    """Where the robot is, x, y, heading, after t seconds."""
    turn = 0.1 * t
    return 4.0 * math.sin(turn) + 1.0, 4.0 * (1.0 - math.cos(turn)) - 2.0, turn


def odometry_at(t):
    """What its wheels say: 2 % too far, from the origin on."""
    turn = 0.1 * t
    return 4.08 * math.sin(turn), 4.08 * (1.0 - math.cos(turn)), turn


def correction_at(t):
    """map → odom: what odometry must be moved by."""
    (x, y, h), (ox, oy, oh) = pose_at(t), odometry_at(t)
    turn = h - oh
    c, s = math.cos(turn), math.sin(turn)
    return x - (c * ox - s * oy), y - (s * ox + c * oy), turn


def picture(t):
    rows, columns = np.mgrid[0:PIXELS, 0:PIXELS]
    pixels = np.stack([rows * 9 + int(10 * t), columns * 9, rows * 0 + 40], axis=-1) % 256
    file = io.BytesIO()
    Image.fromarray(pixels.astype(np.uint8)).save(file, "PNG")
    return np.frombuffer(file.getvalue(), dtype=np.uint8)


def messages(store, ros1):
    """(topic, type, nanoseconds of logging, message) of the drive in the order of logging."""
    types = store.types
    make = lambda name: types[name]

    def stamp(ns):
        return make("builtin_interfaces/msg/Time")(sec=ns // 10**9, nanosec=ns % 10**9)

    def header(ns, frame):
        extra = {"seq": 0} if ros1 else {}
        return make("std_msgs/msg/Header")(stamp=stamp(ns), frame_id=frame, **extra)

    def rotation(yaw, roll=0.0):
        cr, sr, cy, sy = math.cos(roll / 2), math.sin(roll / 2), math.cos(yaw / 2), math.sin(yaw / 2)
        return make("geometry_msgs/msg/Quaternion")(x=sr * cy, y=sr * sy, z=cr * sy, w=cr * cy)

    def pose(x, y, yaw):
        point = make("geometry_msgs/msg/Point")(x=x, y=y, z=0.0)
        return make("geometry_msgs/msg/Pose")(position=point, orientation=rotation(yaw))

    def transform(ns, parent, child, x, y, yaw, z=0.0, roll=0.0):
        vector = make("geometry_msgs/msg/Vector3")(x=x, y=y, z=z)
        moved = make("geometry_msgs/msg/Transform")(translation=vector, rotation=rotation(yaw, roll))
        named = make("geometry_msgs/msg/TransformStamped")
        return named(header=header(ns, parent), child_frame_id=child, transform=moved)

    def tf(*transforms):
        return make("tf2_msgs/msg/TFMessage")(transforms=list(transforms))

    def odometry(ns, t):
        zero = make("geometry_msgs/msg/Vector3")(x=0.0, y=0.0, z=0.0)
        twist = make("geometry_msgs/msg/Twist")(linear=zero, angular=zero)
        return make("nav_msgs/msg/Odometry")(
            header=header(ns, "odom"),
            child_frame_id="base_link",
            pose=make("geometry_msgs/msg/PoseWithCovariance")(pose=pose(*odometry_at(t)), covariance=np.zeros(36)),
            twist=make("geometry_msgs/msg/TwistWithCovariance")(twist=twist, covariance=np.zeros(36)),
        )

    def scan(ns, t):
        step = math.pi / BEAMS
        ranges = np.array([1.5 + 0.25 * i + 0.125 * math.sin(t + i) for i in range(BEAMS)], dtype=np.float32)
        ranges[3], ranges[4], ranges[5] = np.inf, 0.05, 12.0  # no return, too near, too far
        return make("sensor_msgs/msg/LaserScan")(
            header=header(ns, "laser"),
            angle_min=-math.pi / 2,
            angle_max=-math.pi / 2 + (BEAMS - 1) * step,
            angle_increment=step,
            time_increment=0.0,
            scan_time=0.1,
            range_min=0.1,
            range_max=8.0,
            ranges=ranges,
            intensities=np.zeros(0, dtype=np.float32),
        )

    def sonar(ns, t):
        return make("sensor_msgs/msg/Range")(
            header=header(ns, "sonar_left"),
            radiation_type=0,
            field_of_view=0.3,
            min_range=0.2,
            max_range=4.0,
            range=1.0 + 0.1 * t,
        )

    def localised(ns, t):
        x, y, yaw = pose_at(t)
        covered = make("geometry_msgs/msg/PoseWithCovariance")(pose=pose(x + 10.0, y, yaw), covariance=np.zeros(36))
        return make("geometry_msgs/msg/PoseWithCovarianceStamped")(header=header(ns, "map"), pose=covered)

    def camera(ns, t):
        return make("sensor_msgs/msg/CompressedImage")(header=header(ns, "camera"), format="png", data=picture(t))

    static = tf(
        transform(START_NS, "base_link", "laser", 0.2, 0.0, 0.0, z=0.3),
        transform(START_NS, "base_link", "sonar_left", 0.0, 0.15, math.pi / 2),
    )
    said = make("std_msgs/msg/String")(data="hello")
    drive = [("/tf_static", static, 0.0, 0)]
    for tick in range(round(SECONDS * 20) + 1):
        t = tick / 20
        ns = START_NS + tick * 50_000_000
        if tick % 4 == 0:
            drive.append(("/odom", odometry(ns, t), t, 1_000_000))
            moved = [transform(ns, "map", "odom", *correction_at(t)), transform(ns, "odom", "base_link", *odometry_at(t))]
            drive.append(("/tf", tf(*moved), t, 1_000_000))
        if tick % 6 == 3:
            drive.append(("/scan", scan(ns, t), t, LASER_DELAY_NS))
        if tick % 4 == 1:
            drive.append(("/sonar_left", sonar(ns, t), t, 2_000_000))
        if tick % 8 == 0:
            drive.append(("/amcl_pose", localised(ns, t), t, 3_000_000))
        if tick % 20 == 4:
            drive.append(("/camera/image/compressed", camera(ns, t), t, 5_000_000))
        if tick % 20 == 10:
            drive.append(("/chatter", said, t, 1_000_000))
    logged = [(START_NS + round(t * 1e9) + late, topic, message) for topic, message, t, late in drive]
    logged.sort(key=lambda one: one[0])
    return [(topic, message.__msgtype__, ns, message) for ns, topic, message in logged]


def write_rosbag1(path, compression):
    path.unlink(missing_ok=True)
    writer = Writer1(path)
    writer.chunk_threshold = 6000 if SECONDS < 60 else 768 * 1024
    if compression:
        writer.set_compression(compression)
    with writer:
        connections = {}
        for topic, kind, ns, message in messages(STORE1, True):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE1)
            writer.write(connections[topic], ns, STORE1.serialize_ros1(message, kind))


def write_rosbag2(path, storage, mode=None, page=None):
    shutil.rmtree(path, ignore_errors=True)
    writer = Writer2(path, version=9, storage_plugin=storage)
    if mode:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for topic, kind, ns, message in messages(STORE2, False):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE2)
            writer.write(connections[topic], ns, STORE2.serialize_cdr(message, kind))
    if page and SECONDS < 60:
        # Smaller pages, so that a small file has trees of pages and chains of overflow.
        with contextlib.closing(sqlite3.connect(path / f"{path.name}.db3")) as database:
            database.execute(f"PRAGMA page_size = {page}")
            database.execute("VACUUM")


def write_mcap(path, compression, ros1=False, part=slice(None)):
    store = STORE1 if ros1 else STORE2
    with open(path, "wb") as file:
        size = 6000 if SECONDS < 60 else 1 << 20
        writer = McapWriter(file, chunk_size=size, compression=compression, use_chunking=compression is not None, enable_data_crcs=compression is None)
        writer.start(profile="ros1" if ros1 else "ros2")
        channels, schemas = {}, {}
        for number, (topic, kind, ns, message) in enumerate(messages(store, ros1)[part]):
            if kind not in schemas:
                name = kind.replace("/msg/", "/") if ros1 else kind
                text = store.generate_msgdef(kind)[0] if ros1 else ""
                schemas[kind] = writer.register_schema(name, "ros1msg" if ros1 else "ros2msg", text.encode() if len(text) < 300 else b"")
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schemas[kind])
            if ros1:
                data = store.serialize_ros1(message, kind)
            elif number % 2:
                data = store.serialize_cdr(message, kind, little_endian=False)  # both byte orders are CDR
            else:
                data = store.serialize_cdr(message, kind)
            writer.add_message(channels[topic], ns, bytes(data), ns)
        writer.finish()


def write_split(path):
    """A bag that its recorder split in two, with the names of files as old recorders put them down."""
    path.mkdir(exist_ok=True)
    names = [f"{path.name}_{part}.mcap" for part in range(2)]
    half = len(messages(STORE2, False)) // 2
    write_mcap(path / names[0], CompressionType.ZSTD, part=slice(half))
    write_mcap(path / names[1], CompressionType.ZSTD, part=slice(half, None))
    lines = ["rosbag2_bagfile_information:", "  version: 3", "  storage_identifier: mcap", "  relative_file_paths:"]
    lines += [f"    - {path.name}/{name}" for name in names]
    (path / "metadata.yaml").write_text("\n".join(lines) + "\n")


FOLDER.mkdir(exist_ok=True)
write_rosbag1(FOLDER / "none.bag", None)
write_rosbag1(FOLDER / "lz4.bag", Writer1.CompressionFormat.LZ4)
write_rosbag1(FOLDER / "bz2.bag", Writer1.CompressionFormat.BZ2)
write_rosbag2(FOLDER / "plain", StoragePlugin.SQLITE3, page=512)
write_rosbag2(FOLDER / "packed_messages", StoragePlugin.SQLITE3, CompressionMode.MESSAGE, page=1024)
write_rosbag2(FOLDER / "packed_file", StoragePlugin.SQLITE3, CompressionMode.FILE)
write_rosbag2(FOLDER / "packed_mcap", StoragePlugin.MCAP, CompressionMode.FILE)
write_mcap(FOLDER / "none.mcap", CompressionType.NONE)
write_mcap(FOLDER / "lz4.mcap", CompressionType.LZ4)
write_mcap(FOLDER / "zstd.mcap", CompressionType.ZSTD)
write_mcap(FOLDER / "unchunked.mcap", None)
write_mcap(FOLDER / "ros1.mcap", CompressionType.ZSTD, ros1=True)
write_split(FOLDER / "split")
