# SPDX-License-Identifier: Apache-2.0
# Shaders: GLSL to SPIR-V at build time, embedded as numbers.

add_custom_target(shaders)  # all of them, for who only reads the sources (clang-tidy)

# terray_shaders(TARGET a.comp.glsl ...): sources of TARGET may include "<folder in src>/a.comp.inc" between braces.
function(terray_shaders TARGET)
  set(outputs)
  foreach(source ${ARGN})
    cmake_path(ABSOLUTE_PATH source OUTPUT_VARIABLE path)
    cmake_path(RELATIVE_PATH path BASE_DIRECTORY ${CMAKE_SOURCE_DIR}/src OUTPUT_VARIABLE name)
    string(REPLACE ".glsl" "" name ${name})
    set(out ${CMAKE_BINARY_DIR}/generated/${name})
    cmake_path(GET out PARENT_PATH folder)
    file(MAKE_DIRECTORY ${folder})
    set(compile ${TERRAY_GLSLC} --target-env=vulkan1.3 -O -Werror -fshader-stage=compute -I ${CMAKE_SOURCE_DIR}/src)
    set(validate)
    if(TERRAY_SPIRV_VAL)
      set(validate COMMAND ${compile} ${path} -o ${out}.spv COMMAND ${TERRAY_SPIRV_VAL} --target-env vulkan1.3 ${out}.spv)
    endif()
    add_custom_command(OUTPUT ${out}.inc ${validate}
      COMMAND ${compile} -mfmt=num -MD -MF ${out}.d -MT ${out}.inc ${path} -o ${out}.inc
      DEPENDS ${path} DEPFILE ${out}.d COMMENT "Compiling shader ${name}" VERBATIM)
    target_sources(${TARGET} PRIVATE ${out}.inc)
    list(APPEND outputs ${out}.inc)
  endforeach()
  add_custom_target(${TARGET}_shaders DEPENDS ${outputs})
  add_dependencies(${TARGET} ${TARGET}_shaders)
  add_dependencies(shaders ${TARGET}_shaders)
  target_include_directories(${TARGET} PRIVATE ${CMAKE_BINARY_DIR}/generated)
endfunction()
