WOVEN = {}
