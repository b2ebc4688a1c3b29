# SPDX-License-Identifier: Apache-2.0
# Run by ctest: installs BUILD below WORK, checks what is there, builds and runs the consumer and terray.
set(prefix ${WORK}/prefix)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "'${ARGN}' gave ${code}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
foreach(path bin/terray lib/libterray.so include/terray/terray.h lib/cmake/Terray/TerrayConfig.cmake
             share/doc/terray/README.md share/doc/terray/docs/surface.md)
  if(NOT EXISTS ${prefix}/${path})
    message(FATAL_ERROR "${path} was not installed")
  endif()
endforeach()

# Moved, it still works: nothing installed names the place where it was installed.
file(RENAME ${prefix} ${WORK}/moved)
set(prefix ${WORK}/moved)

run(${CMAKE_COMMAND} -S ${SOURCE}/consumer -B ${WORK}/consumer -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/consumer ${WORK})
if(NOT output MATCHES "version ${VERSION}, [1-9][0-9]* hits")
  message(FATAL_ERROR "the consumer said: ${output}")
endif()

run(${prefix}/bin/terray --version)
if(NOT output MATCHES "${VERSION}")
  message(FATAL_ERROR "terray --version said: ${output}")
endif()
run(${prefix}/bin/terray render ${WORK}/ridge.asc --assign-crs EPSG:32632 --size 160x90 -o ${WORK}/ridge.png)
if(NOT EXISTS ${WORK}/ridge.png)
  message(FATAL_ERROR "the installed terray made no picture: ${output}")
endif()
