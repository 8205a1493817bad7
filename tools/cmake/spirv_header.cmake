# Writes the words of a SPIR-V file as a C++ array:
#   cmake -DIN=x.spv -DOUT=x.h -DNAME=kX -P spirv_header.cmake
file(READ ${IN} hex HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," words ${hex})
string(REPEAT "0x........," 8 line)
string(REGEX REPLACE "(${line})" "\\1\n" words ${words})
file(WRITE ${OUT}
     "#pragma once\n#include <cstdint>\ninline constexpr std::uint32_t ${NAME}[] = {\n${words}};\n")
