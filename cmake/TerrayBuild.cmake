# SPDX-License-Identifier: Apache-2.0
# Compiler settings shared by every target, and terray_room(), which declares one folder of src/.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(TERRAY_CCACHE ccache)
if(TERRAY_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TERRAY_CCACHE})
endif()

# Headers are read once for all sources of a unit, which halves the time of a whole build; but an edit costs more, and a
# missing include does not show: the dev preset does without.
option(TERRAY_UNITY "Compile several sources in one translation unit" OFF)
set(CMAKE_UNITY_BUILD ${TERRAY_UNITY})
set(CMAKE_UNITY_BUILD_BATCH_SIZE 10)

# Every target of ours links this: warnings, include root, sanitizers.
add_library(terray_settings INTERFACE)
target_include_directories(terray_settings INTERFACE ${CMAKE_SOURCE_DIR}/include ${CMAKE_SOURCE_DIR}/src)
target_compile_options(terray_settings INTERFACE -Wall -Wextra -Wconversion -Wshadow
  $<$<BOOL:${TERRAY_WERROR}>:-Werror> -ffp-contract=off -fno-math-errno)
if(TERRAY_SANITIZE)
  # g++ 12 warns falsely in instrumented code; the four checks left out take as long to compile as all
  # others together, and the address sanitizer sees most of what they would.
  target_compile_options(terray_settings INTERFACE -fsanitize=${TERRAY_SANITIZE}
    -fno-sanitize=null,vptr,alignment,object-size -fno-sanitize-recover=all
    -fno-omit-frame-pointer -Wno-maybe-uninitialized)
  target_link_options(terray_settings INTERFACE -fsanitize=${TERRAY_SANITIZE})
endif()

set(TERRAY_LONG_TESTS bake engine kernel stream)
if(TERRAY_BUILD_TESTS)
  add_custom_target(unit_tests)  # all unit-test programs
endif()

# terray_room(NAME SOURCES ... [DEPS rooms or libraries ...] [TESTS ...] [TEST_DEPS ...])
# One static library terray_NAME and, with tests on, one GoogleTest program NAME_test.
function(terray_room NAME)
  cmake_parse_arguments(ROOM "" "" "SOURCES;DEPS;TESTS;TEST_DEPS" ${ARGN})
  add_library(terray_${NAME} STATIC ${ROOM_SOURCES})
  target_link_libraries(terray_${NAME} PUBLIC terray_settings ${ROOM_DEPS})
  if(TERRAY_BUILD_TESTS AND ROOM_TESTS)
    add_executable(${NAME}_test ${ROOM_TESTS})
    target_link_libraries(${NAME}_test PRIVATE terray_${NAME} ${ROOM_TEST_DEPS} GTest::gtest GTest::gmock GTest::gtest_main)
    add_test(NAME ${NAME} COMMAND ${NAME}_test)
    set_tests_properties(${NAME} PROPERTIES TIMEOUT 600 LABELS unit)
    list(FIND TERRAY_LONG_TESTS ${NAME} place)
    if(place GREATER -1)
      set_tests_properties(${NAME} PROPERTIES COST 100)  # begun first, so that cores are not left idle at the end
    endif()
    add_dependencies(unit_tests ${NAME}_test)
    # Tests are compiled more often than run: up to a third sooner so. Long ones make their terrains by themselves.
    if(TERRAY_SANITIZE AND place EQUAL -1)
      target_compile_options(${NAME}_test PRIVATE -O0)
    else()
      target_compile_options(${NAME}_test PRIVATE -O1)
    endif()
  endif()
endfunction()
