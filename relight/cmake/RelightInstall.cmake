# What `cmake --install` puts where: the program with its man page and completions, the
# package of find_package(relight) and relight.pc. Libraries, headers and data files are
# installed by the stage they belong to.

include(CMakePackageConfigHelpers)

# --- External libraries of the stages ----------------------------------------------
#
# Each library that a stage links is known here once: how a user of the package finds it
# again, and how pkg-config names it. A stage that links another is an error at configure.
# The targets of pkg_check_modules(NAME IMPORTED_TARGET module) need no line.

set(RELIGHT_EXTERNALS "" CACHE INTERNAL "")

# relight_external(NAME MATCHES regex [FIND cmake-lines] [PC module] [LIBS flags] [CFLAGS flags])
function(relight_external name)
  cmake_parse_arguments(ARG "" "MATCHES;FIND;PC;LIBS;CFLAGS" "" ${ARGN})
  set(RELIGHT_EXTERNALS ${RELIGHT_EXTERNALS} ${name} CACHE INTERNAL "")
  foreach(key MATCHES FIND PC LIBS CFLAGS)
    set(RELIGHT_EXTERNAL_${name}_${key} "${ARG_${key}}" CACHE INTERNAL "")
  endforeach()
endfunction()

relight_external(eigen MATCHES "^Eigen3::Eigen$" PC eigen3
  FIND "find_dependency(Eigen3 3.4 NO_MODULE)")
relight_external(opencv MATCHES "^opencv_[a-z0-9]+$" CFLAGS "-I${OpenCV_INCLUDE_DIRS}"
  FIND "find_dependency(OpenCV 4.6 COMPONENTS @components@)")
relight_external(tbb MATCHES "^TBB::tbb$" PC tbb FIND "find_dependency(TBB)")
relight_external(fmt MATCHES "^fmt::" PC fmt FIND "find_dependency(fmt)")
relight_external(spdlog MATCHES "^spdlog::" PC spdlog FIND "find_dependency(spdlog)")
relight_external(json MATCHES "^nlohmann_json::" PC nlohmann_json
  FIND "find_dependency(nlohmann_json)")
relight_external(pugixml MATCHES "^pugixml::" PC pugixml FIND "find_dependency(pugixml)")
relight_external(toml MATCHES "^tomlplusplus::" PC tomlplusplus
  FIND "find_dependency(tomlplusplus)")
relight_external(highway MATCHES "^hwy::" PC libhwy FIND "find_dependency(hwy)")
relight_external(date MATCHES "^date::" LIBS "-ldate-tz" FIND "find_dependency(date)")
relight_external(threads MATCHES "^Threads::Threads$" LIBS "-pthread"
  FIND "find_dependency(Threads)")

set(RELIGHT_FIND_DEPENDENCIES "")
set(RELIGHT_PC_REQUIRES "")
set(RELIGHT_PC_CFLAGS "")
set(RELIGHT_PC_LIBS "")

# Everything that the stages link, in order; `$<LINK_ONLY:x>` is how CMake keeps a static
# library's private x
set(linked "")
list(FILTER RELIGHT_TARGETS EXCLUDE REGEX "^$")
foreach(target IN LISTS RELIGHT_TARGETS)
  get_target_property(type ${target} TYPE)
  if(NOT type STREQUAL INTERFACE_LIBRARY)
    list(PREPEND RELIGHT_PC_LIBS -l${target})
  endif()
  get_target_property(libraries ${target} INTERFACE_LINK_LIBRARIES)
  foreach(library IN LISTS libraries)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" library "${library}")
    if(NOT library MATCHES "^relight::|^\\$<BUILD_INTERFACE:|NOTFOUND$")
      list(APPEND linked "${library}")
    endif()
  endforeach()
endforeach()
list(REMOVE_DUPLICATES linked)

foreach(library IN LISTS linked)
  if(library MATCHES "^PkgConfig::(.+)$")
    set(name ${CMAKE_MATCH_1})
    list(APPEND RELIGHT_FIND_DEPENDENCIES "find_dependency(PkgConfig)"
      "pkg_check_modules(${name} REQUIRED QUIET IMPORTED_TARGET ${${name}_MODULE_NAME})")
    list(APPEND RELIGHT_PC_REQUIRES ${${name}_MODULE_NAME})
    continue()
  endif()
  set(known "")
  foreach(name IN LISTS RELIGHT_EXTERNALS)
    if(library MATCHES "${RELIGHT_EXTERNAL_${name}_MATCHES}")
      set(known ${name})
      break()
    endif()
  endforeach()
  if(known)
    list(APPEND RELIGHT_FIND_DEPENDENCIES "${RELIGHT_EXTERNAL_${known}_FIND}")
    list(APPEND RELIGHT_PC_REQUIRES ${RELIGHT_EXTERNAL_${known}_PC})
    list(APPEND RELIGHT_PC_CFLAGS ${RELIGHT_EXTERNAL_${known}_CFLAGS})
    list(APPEND RELIGHT_PC_LIBS ${RELIGHT_EXTERNAL_${known}_LIBS})
    if(known STREQUAL opencv)
      list(APPEND opencv_modules ${library})
      list(APPEND RELIGHT_PC_LIBS -l${library})
    endif()
  elseif(library MATCHES "::|\\$<" OR TARGET ${library})
    message(FATAL_ERROR "A stage links ${library}, which relight/cmake/RelightInstall.cmake "
            "does not know: add a relight_external() line so that an installed relight "
            "finds it again")
  elseif(library MATCHES "^[-/]")
    list(APPEND RELIGHT_PC_LIBS ${library})
  else()
    list(APPEND RELIGHT_PC_LIBS -l${library})
  endif()
endforeach()

foreach(list RELIGHT_FIND_DEPENDENCIES RELIGHT_PC_REQUIRES RELIGHT_PC_CFLAGS)
  list(REMOVE_DUPLICATES ${list})
endforeach()
list(TRANSFORM opencv_modules REPLACE "^opencv_" "")
list(JOIN opencv_modules " " opencv_modules)
list(JOIN RELIGHT_FIND_DEPENDENCIES "\n" RELIGHT_FIND_DEPENDENCIES)
string(REPLACE "@components@" "${opencv_modules}"
       RELIGHT_FIND_DEPENDENCIES "${RELIGHT_FIND_DEPENDENCIES}")
list(JOIN RELIGHT_PC_REQUIRES " " RELIGHT_PC_REQUIRES)
list(JOIN RELIGHT_PC_CFLAGS " " RELIGHT_PC_CFLAGS)
list(JOIN RELIGHT_PC_LIBS " " RELIGHT_PC_LIBS)

# --- The package ------------------------------------------------------------------

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/relight)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/relightConfig.cmake.in
  ${PROJECT_BINARY_DIR}/relightConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/relightConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(EXPORT relightTargets NAMESPACE relight:: DESTINATION ${package_dir})
install(FILES ${PROJECT_BINARY_DIR}/relightConfig.cmake
              ${PROJECT_BINARY_DIR}/relightConfigVersion.cmake DESTINATION ${package_dir})

set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH RELIGHT_PREFIX_FROM_PC /${pc_dir} /)
string(REGEX REPLACE "/$" "" RELIGHT_PREFIX_FROM_PC "${RELIGHT_PREFIX_FROM_PC}")
configure_file(${CMAKE_CURRENT_LIST_DIR}/relight.pc.in ${PROJECT_BINARY_DIR}/relight.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/relight.pc DESTINATION ${pc_dir})

# --- The program ------------------------------------------------------------------

if(TARGET relight_cli)
  install(TARGETS relight_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

  # The program prints its own pages, so that none can drift from its flags.
  # relight_page(FILE FOLDER VERB…): `relight VERB…` written to FILE, installed in FOLDER
  set(pages "")
  function(relight_page file folder)
    set(page ${PROJECT_BINARY_DIR}/pages/${file})
    add_custom_command(OUTPUT ${page}
      COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:relight_cli> "-DVERB=${ARGN}"
              -DPAGE=${page} -P ${PROJECT_SOURCE_DIR}/relight/cmake/PrintPage.cmake
      DEPENDS relight_cli ${PROJECT_SOURCE_DIR}/relight/cmake/PrintPage.cmake
      COMMENT "Printing ${file}" VERBATIM)
    install(FILES ${page} DESTINATION ${folder})
    set(pages ${pages} ${page} PARENT_SCOPE)
  endfunction()
  relight_page(relight.1 ${CMAKE_INSTALL_MANDIR}/man1 man)
  relight_page(relight ${CMAKE_INSTALL_DATADIR}/bash-completion/completions completion bash)
  relight_page(_relight ${CMAKE_INSTALL_DATADIR}/zsh/site-functions completion zsh)
  relight_page(relight.fish ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d completion fish)
  add_custom_target(relight_pages ALL DEPENDS ${pages})
endif()

# --- Tests of what is around the code ----------------------------------------------

if(RELIGHT_TESTS AND PROJECT_IS_TOP_LEVEL)
  add_subdirectory(${PROJECT_SOURCE_DIR}/tests/habits tests_habits)
  # A sanitized library asks its users for the same sanitizer: nothing to learn there
  if(NOT RELIGHT_SANITIZE)
    add_test(NAME consumer.UsesAnInstalledRelight
      COMMAND ${CMAKE_COMMAND} -DBUILD_DIR=${PROJECT_BINARY_DIR}
              -DCXX=${CMAKE_CXX_COMPILER} -DGENERATOR=${CMAKE_GENERATOR}
              -DLIBDIR=${CMAKE_INSTALL_LIBDIR} "-DTARGETS=${RELIGHT_TARGETS}"
              -P ${PROJECT_SOURCE_DIR}/tests/consumer/run.cmake)
    set_tests_properties(consumer.UsesAnInstalledRelight PROPERTIES
      LABELS consumer TIMEOUT 600)
  endif()
endif()
