# Compiles render/${SHADER} to ${OUT} and validates it for Vulkan 1.3.
execute_process(COMMAND ${GLSLANG} --quiet --target-env vulkan1.3 -I${ROOT} -o ${OUT} ${ROOT}/render/${SHADER}
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${SPIRV_VAL} --target-env vulkan1.3 ${OUT} COMMAND_ERROR_IS_FATAL ANY)
# What the program holds, where spirv-opt has changed it.
if(INLINED)
  execute_process(COMMAND ${SPIRV_VAL} --target-env vulkan1.3 ${INLINED} COMMAND_ERROR_IS_FATAL ANY)
endif()
