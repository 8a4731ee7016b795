# Written, not tried: vcpkg install clsdf --overlay-ports=packaging/vcpkg, in a clone or an unpacked archive. It compiles the
# sources that it lies in.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS features FEATURES io CLSDF_BUILD_IO)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    ${features}
    -DCLSDF_BUILD_APPS=OFF
    -DCLSDF_BUILD_C=OFF
    -DCLSDF_BUILD_EXAMPLES=OFF
    -DCLSDF_BUILD_INTEGRATIONS=OFF
    -DCLSDF_BUILD_PAPERS=OFF
    -DCLSDF_BUILD_PICTURE=OFF
    -DCLSDF_BUILD_REFERENCE=OFF
    -DCLSDF_BUILD_TESTS=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/clsdf)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share"
                    "${CURRENT_PACKAGES_DIR}/share/doc")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
