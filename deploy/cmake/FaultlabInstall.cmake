# cmake --install BUILD [--component server | agent] [--strip] --prefix ..: the server and the agent, each with its unit,
# documents, descriptions of benches and licences. deploy/package makes Debian packages of the two components.
include(GNUInstallDirs)

# faultlab_install(COMPONENT PACKAGE TARGET UNIT): what both have.
function(faultlab_install component package target unit)
  set(doc "${CMAKE_INSTALL_DATADIR}/doc/${package}")
  install(TARGETS ${target} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT ${component})
  # The unit names the program by its path, which the prefix of this installation decides.
  install(CODE "
    file(READ \"${CMAKE_SOURCE_DIR}/deploy/${unit}\" text)
    string(REPLACE /usr/local/bin \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\" text \"\${text}\")
    set(unit \"${CMAKE_BINARY_DIR}/generated/${unit}\")
    file(WRITE \"\${unit}\" \"\${text}\")
    file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/lib/systemd/system\" TYPE FILE FILES \"\${unit}\")
    " COMPONENT ${component})
  install(FILES benches/paper.toml benches/servo-motor.toml benches/gear-motor.toml benches/speed-motor.toml
    DESTINATION "${CMAKE_INSTALL_DATADIR}/${package}/benches" COMPONENT ${component})
  # The folders of the source, so that the documents find each other.
  install(FILES LICENSE SECURITY.md DESTINATION "${doc}" COMPONENT ${component})
  install(FILES deploy/THIRD_PARTY.md deploy/README.md DESTINATION "${doc}/deploy" COMPONENT ${component})
  install(FILES benches/README.md DESTINATION "${doc}/benches" COMPONENT ${component})
  install(FILES hardware/README.md hardware/KIT.md hardware/wiring.svg
    DESTINATION "${doc}/hardware" COMPONENT ${component})
endfunction()

faultlab_install(agent faultlab-rig faultlab_rig faultlab-rig.service)
install(FILES hardware/device/PROTOCOL.md
  DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/faultlab-rig/hardware/device" COMPONENT agent)
install(FILES deploy/examples/rig.env
  DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/faultlab-rig/examples" COMPONENT agent)

if(FAULTLAB_SERVER)
  faultlab_install(server faultlab faultlab faultlab.service)
  install(PROGRAMS deploy/faultlab-backup deploy/faultlab-restore
    DESTINATION "${CMAKE_INSTALL_SBINDIR}" COMPONENT server)
  install(FILES README.md DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/faultlab" COMPONENT server)
  install(FILES deploy/config.example.toml deploy/Caddyfile deploy/grafana/faultlab.json
      deploy/examples/client.py deploy/examples/client.sh deploy/examples/faultlab.py deploy/examples/load_run.py deploy/examples/load_run.m
    DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/faultlab/examples" COMPONENT server)
endif()
