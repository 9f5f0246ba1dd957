"""Where does an agent leave a pipe with a branch? Fly heavier and lighter ones under disturbed conditions."""

import driftform as df

WORD = "addF-tiltp-0-L-moveF-addB-tiltn-0-L-moveB-addF-tiltp-0-L-moveF"

shares = {}
for mass in (0.0085, 0.0095, 0.0105):
    agent = df.open_agent(WORD, "builder.core=custom", f"builder.core_mass={mass}", scenario="t-junction")
    shares[mass] = agent.disturb(20, seed=1).outlet_shares(agent.scenario)
    ways = ", ".join(f"{100 * share:.0f} % by {name}" for name, share in shares[mass].items())
    print(f"core of {1000 * mass:.1f} g, net buoyancy {agent.net_buoyancy:+.3f} N: {ways}")
