# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` lays out: program, library, headers, a CMake package and the pages.
# (terray-bench installs itself: bench/CMakeLists.txt.)
include(CMakePackageConfigHelpers)

install(TARGETS terray_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS terray EXPORT TerrayTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/terray DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Terray)
install(EXPORT TerrayTargets NAMESPACE Terray:: DESTINATION ${package_dir})
configure_package_config_file(cmake/TerrayConfig.cmake.in ${CMAKE_BINARY_DIR}/TerrayConfig.cmake
  INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/TerrayConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/TerrayConfig.cmake ${CMAKE_BINARY_DIR}/TerrayConfigVersion.cmake
  DESTINATION ${package_dir})

install(FILES README.md ARCHITECTURE.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs)
