# Precompiles the headers that most files include, for faster full builds (decision 0063). A file must still include
# what it needs: the builds without FOOTLIGHT_PRECOMPILE check that.
set(FOOTLIGHT_COMMON_HEADERS <algorithm> <array> <charconv> <cmath> <cstdint> <cstdio> <cstdlib> <cstring> <filesystem>
    <fstream> <functional> <limits> <map> <memory> <mutex> <optional> <set> <span> <string> <string_view> <thread>
    <utility> <vector> <fmt/format.h> <tl/expected.hpp>)

# footlight_precompiled(NAME [HEADERS <a.h> ...] [OPTIONS -x ...]): compiles the common headers and HEADERS with the
# options of all files and with OPTIONS. Only files with the same options can use it.
function(footlight_precompiled NAME)
  cmake_parse_arguments(P "" "" "HEADERS;OPTIONS" ${ARGN})
  set(empty ${CMAKE_BINARY_DIR}/precompiled.cpp)
  if(NOT EXISTS ${empty})
    file(WRITE ${empty} "")
  endif()
  add_library(${NAME} OBJECT ${empty})
  target_link_libraries(${NAME} PRIVATE fmt::fmt tl::expected)
  # Not linked: options of linked targets come before the target's own, where -fno-... must be last.
  target_compile_options(${NAME} PRIVATE $<TARGET_PROPERTY:footlight_options,INTERFACE_COMPILE_OPTIONS> ${P_OPTIONS})
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    target_compile_options(${NAME} PRIVATE "SHELL:-Xclang -fno-pch-timestamp")  # the same bytes each time, for caches
  endif()
  target_precompile_headers(${NAME} PRIVATE ${FOOTLIGHT_COMMON_HEADERS} ${P_HEADERS})
endfunction()

# Makes every target of this folder and those below it use the precompiled headers of PRECOMPILED.
function(footlight_use_precompiled FOLDER PRECOMPILED)
  get_property(targets DIRECTORY ${FOLDER} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type MATCHES "EXECUTABLE|STATIC_LIBRARY|OBJECT_LIBRARY")
      target_precompile_headers(${target} REUSE_FROM ${PRECOMPILED})
    endif()
  endforeach()
  get_property(folders DIRECTORY ${FOLDER} PROPERTY SUBDIRECTORIES)
  foreach(folder IN LISTS folders)
    footlight_use_precompiled(${folder} ${PRECOMPILED})
  endforeach()
endfunction()
