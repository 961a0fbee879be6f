# Installs a build into a new folder, builds a program against it twice, through
# find_package and through pkg-config, and runs both.
# cmake -DBUILD_DIR=… -DCXX=… -DGENERATOR=… -DLIBDIR=… -DTARGETS=… -P run.cmake

set(work ${BUILD_DIR}/consumer)
file(REMOVE_RECURSE ${work})
set(prefix ${work}/prefix)
# Moved after the install: nothing in the package may remember where it was first
set(moved ${work}/moved)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE text
                  ERROR_VARIABLE text WORKING_DIRECTORY ${work})
  if(NOT status EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${status}:\n${text}")
  endif()
endfunction()

file(MAKE_DIRECTORY ${work})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})
file(RENAME ${prefix} ${moved})

# Through find_package, each stage
list(TRANSFORM TARGETS REPLACE "^relight_" "" OUTPUT_VARIABLE stages)
list(REMOVE_ITEM stages "")
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${work}/build -G ${GENERATOR}
    -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${moved} "-DSTAGES=${stages}")
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/consumer)

# Through pkg-config
find_program(PKG_CONFIG pkg-config REQUIRED)
set(ENV{PKG_CONFIG_PATH} ${moved}/${LIBDIR}/pkgconfig)
execute_process(COMMAND ${PKG_CONFIG} --cflags --libs relight OUTPUT_VARIABLE flags
                ERROR_VARIABLE errors RESULT_VARIABLE status
                OUTPUT_STRIP_TRAILING_WHITESPACE)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "pkg-config does not find relight: ${errors}")
endif()
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${CXX} -std=c++20 ${CMAKE_CURRENT_LIST_DIR}/consumer.cpp ${flags} -o ${work}/consumer_pc)
run(${work}/consumer_pc)
