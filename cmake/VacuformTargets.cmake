# The common rules for all targets of the project: the language, the warnings, one instruction set, exact floating point.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_program(CCACHE ccache)
if(CCACHE)  # paths relative to the checkout, so that checkouts share the cache
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
                                  ${CCACHE})
endif()

# The same bytes on every machine: one instruction set for all, no contraction into fused multiply-adds.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set(VACUFORM_MARCH -march=x86-64-v2)
endif()

# What Debian builds its packages with, and the checks of the standard library, in what is installed. Debian's compilers
# make programs that lie anywhere (PIE). tests/check/hardening reads the result.
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  set(VACUFORM_HARDENING -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=3 -D_GLIBCXX_ASSERTIONS -fstack-protector-strong
                         -fstack-clash-protection)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    list(APPEND VACUFORM_HARDENING -fcf-protection)
  endif()
  add_link_options(-Wl,-z,relro,-z,now,-z,noexecstack)
endif()

function(vacuform_rules target)
  target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -ffp-contract=off ${VACUFORM_MARCH}
                         ${VACUFORM_HARDENING})
  if(CMAKE_UNITY_BUILD)  # it joins several files, so their local names look like those of a header
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  target_link_libraries(${target} PUBLIC Threads::Threads)
endfunction()

# vacuform_library(name SOURCES ... LINKS ... [PRIVATE_LINKS ...])
function(vacuform_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS;PRIVATE_LINKS" ${ARGN})
  add_library(${name} STATIC ${arg_SOURCES})
  target_link_libraries(${name} PUBLIC ${arg_LINKS} PRIVATE ${arg_PRIVATE_LINKS})
  vacuform_rules(${name})
endfunction()

# vacuform_program(name SOURCES ... LINKS ...)
function(vacuform_program name)
  cmake_parse_arguments(arg "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINKS})
  vacuform_rules(${name})
endfunction()

# The package of Debian determines the version of Embree; the same source supports 3 and 4.
function(vacuform_find_embree)
  find_package(embree 4 QUIET)
  if(NOT embree_FOUND)
    find_package(embree 3 REQUIRED)
  endif()
  add_library(vacuform_embree INTERFACE)
  target_link_libraries(vacuform_embree INTERFACE embree)
  target_compile_definitions(vacuform_embree INTERFACE VACUFORM_EMBREE=${embree_VERSION_MAJOR})
  add_library(vacuform::embree ALIAS vacuform_embree)
endfunction()
