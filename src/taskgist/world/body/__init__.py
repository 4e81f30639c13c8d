"""Bodies: profiles, the models behind them, hands and postures; human or robot, by one file each."""
