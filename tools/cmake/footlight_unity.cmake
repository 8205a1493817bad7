# Compiles the files of each folder as one (a "unity build"), for a shorter build from nothing (decision 0097). The
# files of a folder then share one anonymous namespace: a name may stand in only one of them.

# Files of one shape name what they have in common alike (kModels; Options, add). Each of these is compiled alone.
set(FOOTLIGHT_ALIKE drivers/widgets tools/footlight/commands)

# For every target of this folder and those below it.
function(footlight_unity FOLDER)
  get_property(targets DIRECTORY ${FOLDER} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(NOT type MATCHES "EXECUTABLE|STATIC_LIBRARY|OBJECT_LIBRARY")
      continue()
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    get_target_property(sources ${target} SOURCES)
    foreach(source IN LISTS sources)
      cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${FOLDER} OUTPUT_VARIABLE path)
      cmake_path(GET path PARENT_PATH parent)
      cmake_path(RELATIVE_PATH parent BASE_DIRECTORY ${CMAKE_SOURCE_DIR})
      if(NOT parent IN_LIST FOOTLIGHT_ALIKE)
        string(MAKE_C_IDENTIFIER ${parent} group)
        set_source_files_properties(${path} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${group})
      endif()
    endforeach()
  endforeach()
  get_property(folders DIRECTORY ${FOLDER} PROPERTY SUBDIRECTORIES)
  foreach(folder IN LISTS folders)
    footlight_unity(${folder})
  endforeach()
endfunction()
