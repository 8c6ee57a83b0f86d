vacuform_test(forming_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/sheet_grid_test.cpp ${CMAKE_CURRENT_LIST_DIR}/membrane_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/trapped_air_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/findings_test.cpp ${CMAKE_CURRENT_LIST_DIR}/forming_test.cpp ${CMAKE_CURRENT_LIST_DIR}/point_contact_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/surface_fit_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/projection_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/mass_spring_test.cpp ${CMAKE_CURRENT_LIST_DIR}/exact_cases_test.cpp
  LINKS vacuform_forming)

vacuform_test(heat_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/irradiance_test.cpp ${CMAKE_CURRENT_LIST_DIR}/slab_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/material_test.cpp ${CMAKE_CURRENT_LIST_DIR}/heating_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/measured_field_test.cpp ${CMAKE_CURRENT_LIST_DIR}/sheet_temperature_test.cpp
  LINKS vacuform_forming)
