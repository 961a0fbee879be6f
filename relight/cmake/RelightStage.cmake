# relight_add_stage(NAME HEADERS … SOURCES … AFTER … LINKS … PRIVATE_LINKS …)
#
# One stage of the pipeline: the static library relight_NAME, its alias
# relight::NAME, its header set (each header must compile alone: target
# all_verify_interface_header_sets) and its install rule. AFTER names the earlier
# stages it stands on; LINKS are libraries its headers show, PRIVATE_LINKS those
# that only its sources use.

add_library(relight_warnings INTERFACE)
target_compile_options(relight_warnings INTERFACE -Wall -Wextra -Wpedantic)
if(RELIGHT_WARNINGS_AS_ERRORS)
  target_compile_options(relight_warnings INTERFACE -Werror)
endif()

if(RELIGHT_SANITIZE)
  add_compile_options(-fsanitize=${RELIGHT_SANITIZE} -fno-omit-frame-pointer
                      -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${RELIGHT_SANITIZE})
endif()

set(RELIGHT_TARGETS "" CACHE INTERNAL "Stages, in the order they were added")

function(relight_add_stage name)
  cmake_parse_arguments(ARG "" "" "HEADERS;SOURCES;AFTER;LINKS;PRIVATE_LINKS" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "relight_add_stage(${name}): unknown ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  list(TRANSFORM ARG_AFTER PREPEND relight::)
  set(target relight_${name})

  if(ARG_SOURCES)
    add_library(${target} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:relight_warnings>
                          ${ARG_PRIVATE_LINKS})
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(relight::${name} ALIAS ${target})
  target_sources(${target} ${scope} FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR}
                 FILES ${ARG_HEADERS})
  target_compile_features(${target} ${scope} cxx_std_20)
  target_link_libraries(${target} ${scope} ${ARG_AFTER} ${ARG_LINKS})
  set_target_properties(${target} PROPERTIES
    EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF
    VERIFY_INTERFACE_HEADER_SETS ON)
  install(TARGETS ${target} EXPORT relightTargets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  set(RELIGHT_TARGETS "${RELIGHT_TARGETS};${target}" CACHE INTERNAL "")
endfunction()
