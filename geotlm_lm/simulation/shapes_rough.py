ROUGH = {}
