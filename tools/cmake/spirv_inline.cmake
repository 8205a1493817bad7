# Runs spirv-opt over a SPIR-V file, or takes what it gave for the same bytes in another build folder:
#   cmake -DIN=x.spv -DOUT=x.inlined.spv -DSPIRV_OPT=spirv-opt -DPASSES="--a --b" -DVERSION=text -DCACHE=folder
#         -P spirv_inline.cmake
# CACHE may be empty. VERSION names the spirv-opt: what another one gave is not taken.
set(kept "")
if(CACHE)
  file(SHA256 ${IN} bytes)
  string(SHA256 key "${bytes} ${PASSES} ${VERSION}")
  set(kept ${CACHE}/${key}.spv)
  if(EXISTS ${kept})
    file(COPY_FILE ${kept} ${OUT})
    return()
  endif()
endif()
separate_arguments(passes UNIX_COMMAND "${PASSES}")
execute_process(COMMAND ${SPIRV_OPT} ${passes} ${IN} -o ${OUT} COMMAND_ERROR_IS_FATAL ANY)
if(kept)
  # By another name first: a build beside this one finds whole files only.
  file(MAKE_DIRECTORY ${CACHE})
  string(RANDOM LENGTH 12 part)
  file(COPY_FILE ${OUT} ${kept}.${part}.part)
  file(RENAME ${kept}.${part}.part ${kept})
endif()
