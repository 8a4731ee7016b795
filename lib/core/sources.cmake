target_sources(clsdf PRIVATE)
