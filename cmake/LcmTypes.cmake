# lcm_types(NAME file.lcm ..): generated C++ as an interface target. SYSTEM: the generated code has warnings of its own.
function(lcm_types name)
  find_package(LCM REQUIRED)
  set(out "${CMAKE_CURRENT_BINARY_DIR}/${name}")
  set(headers)
  foreach(file ${ARGN})
    get_filename_component(type "${file}" NAME_WE)
    set(header "${out}/faultlab_msgs/${type}.hpp")
    add_custom_command(OUTPUT "${header}"
      COMMAND "${LCM_GEN}" --cpp --cpp-hpath "${out}" "${CMAKE_CURRENT_SOURCE_DIR}/${file}"
      DEPENDS "${file}" VERBATIM)
    list(APPEND headers "${header}")
  endforeach()
  add_custom_target(${name}_generate DEPENDS ${headers})
  add_library(${name} INTERFACE)
  add_dependencies(${name} ${name}_generate)
  target_include_directories(${name} SYSTEM INTERFACE "${out}")
  target_link_libraries(${name} INTERFACE LCM::lcm)
endfunction()
