# footlight_shaders(TARGET SHADER...): a target that compiles files of the folder shaders/ into headers with one array
# each: step.comp -> shaders/step.comp.h with kStepComp, in the binary folder. Depfiles rebuild exactly the users of a
# changed include. FOOTLIGHT_SOURCE_x: another file that x is compiled from; FOOTLIGHT_DEFINES_x: its -D options.
#
# spirv-opt puts all functions of a shader into its main(): on an NVIDIA H200 calls that a pipeline never makes took 1.8
# times the time of its beams, because the driver had not inlined the others (docs/decisions/0109).
find_program(SPIRV_OPT spirv-opt)
if(NOT SPIRV_OPT)
  message(STATUS "Functions of shaders are not inlined: needs spirv-tools")
endif()
set(FOOTLIGHT_SPIRV_PASSES --target-env=vulkan1.3 --merge-return --inline-entry-points-exhaustive
    --eliminate-dead-functions --scalar-replacement=100 --eliminate-local-single-block --eliminate-local-single-store
    --ssa-rewrite --eliminate-dead-code-aggressive --compact-ids)
# What spirv-opt gave is kept for the other build folders of this tree, and for shaders that are restored
# (docs/decisions/0186).
set(FOOTLIGHT_SHADER_CACHE "" CACHE PATH "Folder for inlined shaders that several build folders share; empty: none")
set(FOOTLIGHT_SHADERS_KEPT_MAX 2000)  # files, 110 kB in the mean
if(FOOTLIGHT_SHADER_CACHE)
  file(GLOB kept ${FOOTLIGHT_SHADER_CACHE}/*.spv)
  list(LENGTH kept count)
  if(count GREATER FOOTLIGHT_SHADERS_KEPT_MAX)
    file(REMOVE ${kept})
  endif()
endif()
set(FOOTLIGHT_SPIRV_OPT_VERSION "")
if(SPIRV_OPT)
  execute_process(COMMAND ${SPIRV_OPT} --version OUTPUT_VARIABLE FOOTLIGHT_SPIRV_OPT_VERSION
                  ERROR_VARIABLE FOOTLIGHT_SPIRV_OPT_VERSION)
  string(MAKE_C_IDENTIFIER "${FOOTLIGHT_SPIRV_OPT_VERSION}" FOOTLIGHT_SPIRV_OPT_VERSION)
endif()
list(JOIN FOOTLIGHT_SPIRV_PASSES " " FOOTLIGHT_SPIRV_PASSES)
set(FOOTLIGHT_SPIRV_INLINE ${CMAKE_CURRENT_LIST_DIR}/spirv_inline.cmake)
set(FOOTLIGHT_SPIRV_HEADER ${CMAKE_CURRENT_LIST_DIR}/spirv_header.cmake)

function(footlight_shaders target)
  set(headers)
  foreach(shader ${ARGN})
    string(REGEX MATCH "^([a-z_]+)\\.([a-z]+)$" unused ${shader})
    string(SUBSTRING ${CMAKE_MATCH_1} 0 1 first)
    string(SUBSTRING ${CMAKE_MATCH_1} 1 -1 rest)
    string(TOUPPER ${first} first)
    string(SUBSTRING ${CMAKE_MATCH_2} 0 1 stage_first)
    string(SUBSTRING ${CMAKE_MATCH_2} 1 -1 stage_rest)
    string(TOUPPER ${stage_first} stage_first)
    set(source ${CMAKE_CURRENT_SOURCE_DIR}/shaders/${shader})
    if(DEFINED FOOTLIGHT_SOURCE_${shader})
      set(source ${CMAKE_CURRENT_SOURCE_DIR}/shaders/${FOOTLIGHT_SOURCE_${shader}})
    endif()
    set(header ${CMAKE_CURRENT_BINARY_DIR}/shaders/${shader}.h)
    set(spirv ${CMAKE_CURRENT_BINARY_DIR}/shaders/${shader}.spv)
    add_custom_command(
      OUTPUT ${spirv}
      COMMAND ${GLSLANG} --quiet --target-env vulkan1.3 -I${CMAKE_SOURCE_DIR} ${FOOTLIGHT_DEFINES_${shader}}
              --depfile ${spirv}.d -o ${spirv} ${source}
      DEPENDS ${source}
      DEPFILE ${spirv}.d
      VERBATIM)
    set(final ${spirv})
    set(inlined)
    set(inline)
    set(tool)
    if(SPIRV_OPT)
      set(inlined ${CMAKE_CURRENT_BINARY_DIR}/shaders/${shader}.inlined.spv)
      set(inline COMMAND ${CMAKE_COMMAND} -DIN=${spirv} -DOUT=${inlined} -DSPIRV_OPT=${SPIRV_OPT}
          -DPASSES=${FOOTLIGHT_SPIRV_PASSES} -DVERSION=${FOOTLIGHT_SPIRV_OPT_VERSION}
          -DCACHE=${FOOTLIGHT_SHADER_CACHE} -P ${FOOTLIGHT_SPIRV_INLINE})
      set(final ${inlined})
      set(tool ${SPIRV_OPT} ${FOOTLIGHT_SPIRV_INLINE})
    endif()
    add_custom_command(
      OUTPUT ${header} ${inlined}
      ${inline}
      COMMAND ${CMAKE_COMMAND} -DIN=${final} -DOUT=${header} -DNAME=k${first}${rest}${stage_first}${stage_rest}
              -P ${FOOTLIGHT_SPIRV_HEADER}
      DEPENDS ${spirv} ${FOOTLIGHT_SPIRV_HEADER} ${tool}
      VERBATIM)
    list(APPEND headers ${header})
  endforeach()
  add_custom_target(${target} DEPENDS ${headers})
endfunction()
