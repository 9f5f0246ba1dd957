"""From a genome to parts: export a kit that takes the core, check it, and trim the print that was weighed."""

import driftform as df
from driftform_kit.check import check_design
from driftform_kit.trim import trim_design

WORD = "addB-tiltn-1-M-moveB-addB-tiltn-2-S-moveB-addB-tiltp-1-L-moveB"

# `pipe-inspection` simulates the kit: sleeves and seats are part of the mass.
agent = df.open_agent(WORD, "exporter.3mf.kit=true")
for path in agent.export("3mf", "parts/agent.3mf"):
    print(path)

findings = check_design(agent, "3mf", programs=False)
print("checks that fail:", [finding.check for finding in findings if finding.state == "fail"])

# The print came out two grams too light.
trim = trim_design(agent, printed_mass=agent.mass.mass - 0.002)
print(f"ballast of {1000 * trim['ballast_mass']:.2f} g at x {1000 * trim['ballast_x']:+.1f} mm of the core's centre")
