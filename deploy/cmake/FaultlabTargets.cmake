# Declares libraries, tests and benchmarks of faultlab: one place for flags and warnings.
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # ccache requires this before it stores objects that use a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE})
endif()
find_program(MOLD mold)
if(MOLD AND NOT CMAKE_CROSSCOMPILING)  # a cross compiler does not find it
  add_link_options(-fuse-ld=mold)
endif()
find_package(Threads REQUIRED)

add_library(faultlab_flags INTERFACE)
target_compile_options(faultlab_flags INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
if(FAULTLAB_WERROR)
  target_compile_options(faultlab_flags INTERFACE -Werror)
endif()
target_include_directories(faultlab_flags INTERFACE "${CMAKE_SOURCE_DIR}" "${CMAKE_BINARY_DIR}/generated")
target_link_libraries(faultlab_flags INTERFACE Threads::Threads)
# All targets get the sanitizers, because a mix of instrumented and plain objects hides errors.
# UBSan's pointer checks (null, alignment, object size, vptr) are left out: with them a typical file
# compiles in 19 s instead of 9 s, and AddressSanitizer finds most of the same errors.
if(FAULTLAB_SANITIZE)
  add_compile_options(-fsanitize=${FAULTLAB_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(FAULTLAB_SANITIZE MATCHES undefined)
    add_compile_options(-fno-sanitize=vptr,null,alignment,object-size)
    if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
      add_compile_options(-fno-sanitize=function)  # clang 14 cannot compile it in coroutines
    endif()
  endif()
  add_link_options(-fsanitize=${FAULTLAB_SANITIZE})
endif()

# faultlab_library(NAME SOURCES a.cc .. [APART b.cc ..] [DEPS public..] [PRIVATE_DEPS ..])
# APART: sources with helpers of the same name as another source's; deploy/tidy reads each of them
# separately.
function(faultlab_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;APART;DEPS;PRIVATE_DEPS" ${ARGN})
  set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(ARG_SOURCES)
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC faultlab_flags ${ARG_DEPS} PRIVATE ${ARG_PRIVATE_DEPS})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE faultlab_flags ${ARG_DEPS})
  endif()
endfunction()

# faultlab_test_headers(NAME): GoogleTest and the headers that it includes, parsed once for all
# tests of this folder and below, which saves a third of a test's compile time. The product has no
# such header, so that its files cannot depend on includes of another file.
function(faultlab_test_headers name)
  find_package(GTest REQUIRED)
  set(empty "${CMAKE_CURRENT_BINARY_DIR}/${name}.cc")
  file(GENERATE OUTPUT "${empty}" CONTENT "")
  add_library(${name} OBJECT "${empty}")
  target_link_libraries(${name} PRIVATE faultlab_flags GTest::gmock)
  target_compile_options(${name} PRIVATE -fpch-preprocess)  # for ccache
  target_precompile_headers(${name} PRIVATE <gmock/gmock.h> <gtest/gtest.h> <chrono> <thread>)
  set(FAULTLAB_TEST_HEADERS ${name} PARENT_SCOPE)
endfunction()

# faultlab_test(NAME SOURCES a_test.cc .. DEPS .. [LABELS ..] [TIMEOUT s] [ALONE]): a GoogleTest
# program, one ctest entry. ALONE: no other test runs at the same time, and a machine that stands
# still is not a failure (tests/support/real_time.h). Tests with longer time limits start earlier.
function(faultlab_test name)
  cmake_parse_arguments(ARG "ALONE" "TIMEOUT" "SOURCES;DEPS;LABELS" ${ARGN})
  find_package(GTest REQUIRED)
  add_executable(${name} ${ARG_SOURCES})
  target_compile_options(${name} PRIVATE -fpch-preprocess)
  set(main GTest::gtest_main)
  if(ARG_ALONE)
    set(main real_time GTest::gtest)
  endif()
  target_link_libraries(${name} PRIVATE faultlab_flags ${ARG_DEPS} GTest::gmock ${main})
  target_precompile_headers(${name} REUSE_FROM ${FAULTLAB_TEST_HEADERS})
  target_compile_definitions(${name} PRIVATE FAULTLAB_TEST_DATA="${CMAKE_SOURCE_DIR}/tests/data")
  add_test(NAME ${name} COMMAND ${name})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}"
                                           RUN_SERIAL ${ARG_ALONE} COST ${ARG_TIMEOUT})
endfunction()

# faultlab_bench(NAME SOURCES .. DEPS ..): a Google Benchmark program, built but not run by ctest.
function(faultlab_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPS" ${ARGN})
  find_package(benchmark REQUIRED)
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE faultlab_flags ${ARG_DEPS} benchmark::benchmark)
endfunction()
