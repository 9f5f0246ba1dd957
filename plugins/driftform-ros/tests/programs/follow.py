"""Follow a live flight by rospy, and print as JSON what arrived.

follow.py SECONDS [CURRENT_AT VX VY VZ [TOPIC [FRAME]]] prints `ready` once it has subscribed, publishes a current when the
clock has run for CURRENT_AT seconds, and ends when it has for SECONDS. It prints the stamps of each topic (null for messages
without), the positions of the odometry, the currents that act, and the names of the markers.
"""

import functools
import json
import sys
import time

import roslib.message
import rospy
from geometry_msgs.msg import TwistStamped

TOPICS = {
    "/clock": "rosgraph_msgs/Clock",
    "/tf": "tf2_msgs/TFMessage",
    "/agent/odom": "nav_msgs/Odometry",
    "/agent/wrench": "geometry_msgs/WrenchStamped",
    "/agent/imu": "sensor_msgs/Imu",
    "/agent/pressure": "sensor_msgs/FluidPressure",
    "/agent/range": "sensor_msgs/Range",
    "/agent/clearance": "std_msgs/Float64",
    "/agent/current": "geometry_msgs/TwistStamped",
    "/agent/markers": "visualization_msgs/MarkerArray",
}
words, (topic, frame) = sys.argv[1:6], (*sys.argv[6:], *("hydrodynamics/current_velocity", "")[len(sys.argv[6:]) :])
seconds, *current = map(float, words)
rospy.init_node("follow", anonymous=True)
stamps = {topic: [] for topic in TOPICS}
places, markers, currents = [], [], []


def take(topic, message):
    if topic == "/agent/markers":
        markers.extend(marker.ns for marker in message.markers)
    parts = getattr(message, "transforms", [message])
    header = getattr(parts[0], "header", None)
    stamp = getattr(message, "clock", header and header.stamp)
    stamps[topic].append(stamp and stamp.to_sec())
    if topic == "/agent/current":
        speed = message.twist.linear
        currents.append([speed.x, speed.y, speed.z])
    if topic == "/agent/odom":
        place = message.pose.pose.position
        places.append([place.x, place.y, place.z])


# rospy itself keeps one message of /clock where /use_sim_time is set, and all subscribers of a process share its queue.
kept = [
    rospy.Subscriber(topic, roslib.message.get_message_class(kind), functools.partial(take, topic), queue_size=-1)
    for topic, kind in TOPICS.items()
]
publisher = rospy.Publisher(topic, TwistStamped, queue_size=10)
print("ready", flush=True)
times = stamps["/clock"]
until = time.monotonic() + 60
while not rospy.is_shutdown() and time.monotonic() < until and not (times and times[-1] - times[0] >= seconds - 1e-6):
    if current and times and times[-1] - times[0] >= current[0]:
        message = TwistStamped()
        message.header.frame_id = frame
        message.twist.linear.x, message.twist.linear.y, message.twist.linear.z = current[1:]
        publisher.publish(message)
        current = []
    time.sleep(0.005)
time.sleep(0.3)
print(json.dumps({"stamps": stamps, "places": places, "markers": markers, "currents": currents}), flush=True)
