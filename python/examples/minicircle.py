"""How much of its link does a DNA minicircle keep as writhe? Units: nm, pN."""

from supercoil import Scene

result = Scene.minicircle(base_pairs=336, sigma=-0.06, salt_mM=150, elements=24).run()
state = result.state
print(f"{result.status}: link {state.link:.3f} = twist {state.twist:.3f} + writhe {state.writhe:.3f}")
print(f"{len(state.contacts['gap'])} contact sites, forces {state.contacts['force'].round(2)} pN")
state.save_picture("minicircle.png")
