# Writes every file of cl/ into one C file: cmake -DROOT=… -DOUTPUT=… -P EmbedKernels.cmake
#
# An array of bytes a file (a string literal may be too long for a compiler), and a table of names, as backend/opencl/source.h
# declares it.
file(GLOB_RECURSE names RELATIVE "${ROOT}/cl" "${ROOT}/cl/*.h" "${ROOT}/cl/*.cl")
list(SORT names)
set(arrays "")
set(entries "")
set(count 0)
foreach(name IN LISTS names)
    file(READ "${ROOT}/cl/${name}" bytes HEX)
    string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
    string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
    string(APPEND arrays "static const unsigned char file${count}[] = {\n${bytes}0};\n")
    string(APPEND entries "    {\"${name}\", (const char *)file${count}, sizeof file${count} - 1},\n")
    math(EXPR count "${count} + 1")
endforeach()
set(text "/* Made by cmake/EmbedKernels.cmake from cl/. */\n#include \"backend/opencl/source.h\"\n\n${arrays}\n")
string(APPEND text "const cpm_kernel_file cpm_kernel_files[] = {\n${entries}};\nconst size_t cpm_kernel_file_count = ${count};\n")
file(WRITE "${OUTPUT}" "${text}")
