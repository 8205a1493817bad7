# Libraries that a build can go without.
include_guard(GLOBAL)

# footlight_optional(TARGET NAME MODULES <module> ... NEEDS <package> ... [IF <option>] WITHOUT "what is left out"
#                    [SOURCES <a.cpp> ...] [INSTEAD <no_a.cpp> ...] [LOADED <target>])
# If pkg-config finds MODULES and the option IF is on: compiles SOURCES into TARGET, with the library linked as
# PkgConfig::NAME. Else compiles INSTEAD, and prints what is left out and which Debian packages it needs. Sets
# FOOTLIGHT_HAVE_NAME for every folder. LOADED: the program loads the library itself, by the functions of that target;
# only the headers are used to build.
function(footlight_optional TARGET NAME)
  cmake_parse_arguments(O "" "IF;WITHOUT;LOADED" "MODULES;NEEDS;SOURCES;INSTEAD" ${ARGN})
  set(have OFF)
  set(wanted ON)
  if(O_IF)
    set(wanted ${${O_IF}})
  endif()
  if(wanted)
    pkg_check_modules(${NAME} IMPORTED_TARGET GLOBAL ${O_MODULES})
    if(${NAME}_FOUND)
      set(have ON)
    else()
      list(JOIN O_NEEDS ", " needs)
      message(STATUS "Building without ${O_WITHOUT}: needs ${needs}")
    endif()
  endif()
  if(have)
    target_sources(${TARGET} PRIVATE ${O_SOURCES})
    if(O_LOADED)
      target_include_directories(${TARGET} SYSTEM PRIVATE ${${NAME}_INCLUDE_DIRS})
      target_link_libraries(${TARGET} PRIVATE ${O_LOADED})
    else()
      target_link_libraries(${TARGET} PRIVATE PkgConfig::${NAME})
    endif()
  else()
    target_sources(${TARGET} PRIVATE ${O_INSTEAD})
  endif()
  set(FOOTLIGHT_HAVE_${NAME} ${have} CACHE INTERNAL "")
endfunction()
