vacuform_test(server_test
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/store_test.cpp ${CMAKE_CURRENT_LIST_DIR}/store_lease_test.cpp ${CMAKE_CURRENT_LIST_DIR}/store_queue_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/sqlite_store_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/http_parts_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_limits_test.cpp ${CMAKE_CURRENT_LIST_DIR}/server_api_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_program_test.cpp ${CMAKE_CURRENT_LIST_DIR}/server_status_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_access_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_stream_test.cpp ${CMAKE_CURRENT_LIST_DIR}/server_digest_test.cpp ${CMAKE_CURRENT_LIST_DIR}/partial_file_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_submission_test.cpp ${CMAKE_CURRENT_LIST_DIR}/server_upload_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_event_test.cpp ${CMAKE_CURRENT_LIST_DIR}/blobs_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/server_semantics_test.cpp ${CMAKE_CURRENT_LIST_DIR}/zip_test.cpp
  LINKS vacuform_service)
target_compile_definitions(server_test PRIVATE VACUFORM_SERVER="$<TARGET_FILE:vacuform-server>")
add_dependencies(server_test vacuform-server)
