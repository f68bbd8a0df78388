# What every target of the project shares: warnings, sanitisers, and the shape of a layer.

add_library(gluevo_build_flags INTERFACE)
target_compile_options(gluevo_build_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual
  # Designated initialisers leave the other members to their defaults on purpose.
  -Wno-missing-field-initializers
  # g++ 12 warns of overlapping copies inside its own std::string (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${GLUEVO_WARNINGS_AS_ERRORS}>:-Werror>)
if(GLUEVO_SANITIZE)
  target_compile_options(gluevo_build_flags INTERFACE
    -fsanitize=${GLUEVO_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(gluevo_build_flags INTERFACE -fsanitize=${GLUEVO_SANITIZE})
endif()
if(GLUEVO_FUZZ)
  target_compile_options(gluevo_build_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# gluevo_precompile(TARGET HEADERS...): headers of other libraries that most of the target's files
# include anyway. Each file still names what it needs: the dev preset builds without this.
function(gluevo_precompile target)
  if(NOT GLUEVO_PRECOMPILE)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE ${ARGN})
  gluevo_see_through_precompiled(${target})
endfunction()

# gluevo_reuse_precompiled(TARGET OTHER): those of OTHER, which is compiled with the same options.
function(gluevo_reuse_precompiled target other)
  if(NOT GLUEVO_PRECOMPILE)
    return()
  endif()
  target_precompile_headers(${target} REUSE_FROM ${other})
  gluevo_see_through_precompiled(${target})
endfunction()

# gluevo_join_sources(TARGET [FILES...]): where headers are precompiled, too, the target's files are
# compiled some at a time; FILES, which have names of their own in common with others, each alone.
function(gluevo_join_sources target)
  if(NOT GLUEVO_PRECOMPILE)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 7)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

function(gluevo_see_through_precompiled target)
  # The first is what ccache needs to see through them. The others: behind them g++ 12 takes its own
  # std::string for ours and warns of it (GCC bug 105651 once more).
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess;-Wno-array-bounds;-Wno-stringop-overflow>)
endfunction()

# gluevo_add_layer(NAME SOURCES...): the library gluevo_NAME (gluevo::NAME), whose public headers
# are the layer's include/ folder; they are installed with it.
function(gluevo_add_layer name)
  add_library(gluevo_${name} STATIC ${ARGN})
  add_library(gluevo::${name} ALIAS gluevo_${name})
  set_target_properties(gluevo_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(gluevo_${name} PUBLIC cxx_std_20)
  target_include_directories(gluevo_${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(gluevo_${name} PRIVATE $<BUILD_INTERFACE:gluevo_build_flags>)
  install(TARGETS gluevo_${name} EXPORT gluevoTargets)
  install(DIRECTORY include/gluevo DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()
