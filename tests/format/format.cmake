# Fails when clang-format would change a source file of the project at `root`.
cmake_minimum_required(VERSION 3.20)
if(NOT clang_format)
  message("skipped: clang-format is not installed")
  return()
endif()
file(GLOB_RECURSE files ${root}/include/*.hpp ${root}/src/*.hpp ${root}/src/*.cpp ${root}/tests/*.hpp
     ${root}/tests/*.cpp ${root}/examples/*.cpp)
execute_process(COMMAND ${clang_format} --dry-run --Werror ${files} RESULT_VARIABLE changed)
if(changed)
  message(FATAL_ERROR "clang-format -i mends this")
endif()
