"""Listen to topics with rospy and tf2, and print what arrived when a line comes on the standard input.

listen.py TOPIC:TYPE ... [--messages N] [--frames PARENT CHILD] [--times T ...] prints `ready` once it has subscribed, and
at the end, when N messages have come or a minute is over, as JSON: the number of messages of each topic, the clock of ROS,
and poses (x, y, z, qw, qx, qy, qz) of CHILD in PARENT, null where tf2 has none.
"""

import argparse
import collections
import functools
import json
import sys
import time

import roslib.message
import rospy
import tf2_ros

parser = argparse.ArgumentParser()
parser.add_argument("topics", nargs="*")
parser.add_argument("--messages", type=int, default=0)
parser.add_argument("--frames", nargs=2)
parser.add_argument("--times", nargs="*", type=float, default=[0.0])
given = parser.parse_args()

rospy.init_node("listen", anonymous=True)
counts = collections.Counter()
kept = []


def count(topic, _):
    counts[topic] += 1


for topic in given.topics:
    name, _, kind = topic.partition(":")
    message = roslib.message.get_message_class(kind)
    # rospy itself keeps one message of /clock, and all subscribers of a process share the queue of a topic.
    kept.append(rospy.Subscriber(name, message, functools.partial(count, name), queue_size=-1))
frames = tf2_ros.Buffer()
kept.append(tf2_ros.TransformListener(frames))
print("ready", flush=True)
sys.stdin.readline()
until = time.monotonic() + 600
while sum(counts.values()) < given.messages and time.monotonic() < until:
    time.sleep(0.05)
# What comes late, to tf2 too, and what should not come.
time.sleep(0.5)
poses = []
for t in given.times if given.frames else []:
    if not frames.can_transform(*given.frames, rospy.Time.from_sec(t)):
        poses.append(None)
        continue
    found = frames.lookup_transform(*given.frames, rospy.Time.from_sec(t)).transform
    place, turn = found.translation, found.rotation
    poses.append([place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z])
print(json.dumps({"counts": counts, "clock": rospy.get_time(), "poses": poses}), flush=True)
