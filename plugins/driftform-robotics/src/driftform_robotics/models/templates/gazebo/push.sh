#!/bin/sh
# Releases the agent at {{ model.link.velocity|numbers }} m/s: run this while the world is paused, then press play.
# The wrench acts for the first step, {{ step|numbers }} s: it is the momentum of the agent and its added mass over that time.
exec {{ gazebo.program }} topic -t /world/{{ world }}/wrench -m {{ gazebo.messages }}.EntityWrench -p '
entity: {name: "{{ model.title }}::base_link", type: LINK}
wrench: {
  force: {{ (model.link.momentum / step)[:3]|fields }}
  torque: {{ (model.link.momentum / step)[3:]|fields }}
}'
